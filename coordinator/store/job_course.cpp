#include "coordinator/store/job_course.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <nlohmann/json.hpp>
#include <string>

#include "common/base/error.h"

namespace parray::store {
namespace {

using nlohmann::json;

double read_positive(const json& map, const char* key) {
  const double value = map.value(key, 0.0);
  if (!(value >= 0 && std::isfinite(value))) {
    throw RunError(std::string("course: ") + key + " is out of range");
  }
  return value;
}

}  // namespace

void JobCourse::add(const ErrorPoint& point) {
  while (!curve.empty() && curve.back().samples >= point.samples) curve.pop_back();
  if (curve.size() >= most_points) {
    std::size_t kept = 0;
    for (std::size_t i = 1; i < curve.size(); i += 2) curve[kept++] = curve[i];
    curve.resize(kept);
  }
  curve.push_back(point);
}

json curve_to_json(const std::vector<ErrorPoint>& curve) {
  json list = json::array();
  for (const ErrorPoint& point : curve) {
    list.push_back({{"seconds", point.seconds},
                    {"samples", point.samples},
                    {"rmse", point.rmse < 0 ? json() : json(point.rmse)}});
  }
  return list;
}

json course_to_json(const JobCourse& course) {
  return {{"submitted", course.submitted},       {"started", course.started},
          {"finished", course.finished},         {"taken", course.taken},
          {"progress", course.progress},         {"samples", course.samples},
          {"curve", curve_to_json(course.curve)}};
}

JobCourse course_from_json(const json& map) {
  JobCourse course;
  course.submitted = read_positive(map, "submitted");
  course.started = read_positive(map, "started");
  course.finished = read_positive(map, "finished");
  course.taken = read_positive(map, "taken");
  course.progress = std::min(read_positive(map, "progress"), 1.0);
  course.samples = map.value("samples", std::uint64_t{0});
  for (const json& point : map.value("curve", json::array())) {
    const json rmse = point.value("rmse", json());
    course.add({read_positive(point, "seconds"), read_positive(point, "samples"),
                rmse.is_null() ? -1 : read_positive(point, "rmse")});
  }
  return course;
}

}  // namespace parray::store
