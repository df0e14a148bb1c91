#include <doctest/doctest.h>

#include <nlohmann/json.hpp>

#include "common/base/error.h"
#include "common/scene/settings.h"
#include "coordinator/store/job_record.h"
#include "tests/support/rooms.h"
#include "tests/support/sample_scenes.h"

namespace parray {
namespace {

using nlohmann::json;

TEST_CASE("the curve of the error is bounded, and keeps its order and its last point") {
  JobCourse course;
  for (int i = 1; i <= 5000; ++i) course.add({static_cast<double>(i), 2.0 * i, 1.0 / i});
  CHECK(course.curve.size() <= JobCourse::most_points);
  CHECK(course.curve.size() >= JobCourse::most_points / 2);
  CHECK(course.curve.back().samples == 10000);
  for (std::size_t i = 1; i < course.curve.size(); ++i) {
    CHECK(course.curve[i - 1].samples < course.curve[i].samples);
  }
}

TEST_CASE("a picture that lost samples loses the points of its curve that had them") {
  JobCourse course;
  for (const double samples : {2.0, 4.0, 8.0}) course.add({samples, samples, 0.5});
  course.add({9, 4, 0.25});
  REQUIRE(course.curve.size() == 2);
  CHECK(course.curve[1].rmse == 0.25);
}

JobRecord some_record() {
  JobRecord job;
  job.id = 7;
  job.scene = std::string(64, 'a');
  job.settings = test::small_settings(test::small_scene());
  return job;
}

TEST_CASE("a course survives being stored; unknown errors are null") {
  JobRecord job = some_record();
  JobCourse& course = job.course;
  course.submitted = 1e9;
  course.started = 1e9 + 1;
  course.finished = 1e9 + 2.5;
  course.taken = 1.25;
  course.progress = 0.5;
  course.samples = 77;
  course.add({0.5, 2, -1});
  course.add({1, 4, 0.125});
  course.error = {0.125, 0.0625, 0.25, -1, 0.5};
  CHECK(curve_to_json(course.curve)[0].at("rmse").is_null());
  json record = json::parse(record_to_json(job));
  CHECK(record_from_json(7, record.dump()).course == course);
  record["course"]["taken"] = -1;
  CHECK_THROWS_AS(record_from_json(7, record.dump()), RunError);
  record["course"] = json::object();
  CHECK(record_from_json(7, record.dump()).course == JobCourse());
}

TEST_CASE("a course whose picture is lost keeps its times alone") {
  JobCourse course;
  course.taken = 3;
  JobCourse with_picture = course;
  with_picture.progress = 0.5;
  with_picture.samples = 77;
  with_picture.add({1, 4, 0.125});
  with_picture.error.rmse = 0.125;
  with_picture.forget_picture();
  CHECK(with_picture == course);
}

TEST_CASE("a record keeps its course, and may lack it") {
  JobRecord job = some_record();
  job.course.taken = 3;
  json record = json::parse(record_to_json(job));
  CHECK(record_from_json(7, record.dump()).course.taken == 3);
  record.erase("course");
  CHECK(record_from_json(7, record.dump()).course.taken == 0);
}

}  // namespace
}  // namespace parray
