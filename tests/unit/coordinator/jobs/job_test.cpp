#include "coordinator/jobs/job.h"

#include <doctest/doctest.h>

#include <nlohmann/json.hpp>

#include "common/scene/limits.h"
#include "common/scene/settings.h"
#include "tests/support/rooms.h"

namespace parray {
namespace {

using nlohmann::json;

/// A job of 100 pixels with a target, in its second pass.
Job job_in_second_pass() {
  Job job;
  RenderSettings& s = job.record.settings;
  s.width = s.height = 10;
  s.samples_per_pixel = limits::max_samples_per_pixel;
  s.target_error = 0.01;
  job.work = std::make_unique<JobWork>();
  job.work->plan = std::make_shared<const WorkPlan>(s, Pass{{{0, 8}}, {}});
  job.phase = JobPhase::tracing;
  job.record.state = JobState::running;
  job.work->samples = job.work->pass_samples = 800;
  job.work->expected_samples = 1600;
  job.work->pass_progress = 0.8;  // of an optimistic first forecast
  return job;
}

TEST_CASE("the progress towards a target does not fall when a later pass needs more samples") {
  Job job = job_in_second_pass();
  double shown = job.progress(seconds(1));
  CHECK(shown == 0.8);
  for (job.work->samples = 900; job.work->samples <= 1600; job.work->samples += 100) {
    const double next = job.progress(seconds(1));
    CHECK(next > shown);
    shown = next;
  }
  CHECK(shown == 0.99);  // another pass may follow
  job.record.state = JobState::done;
  CHECK(job.progress(seconds(1)) == 1);
}

TEST_CASE("the time left follows the latest forecast, not the shown progress") {
  Job job = job_in_second_pass();
  job.work->started = job.work->clock_began = job.traced_since = seconds(0);
  CHECK(job.seconds_left(seconds(8)) == doctest::Approx(8));
  job.record.settings->time_limit = 10;
  CHECK(job.seconds_left(seconds(8)) == doctest::Approx(2));
}

TEST_CASE("the speed counts only the samples of this process") {
  Job job = job_in_second_pass();
  job.work->started = job.traced_since = seconds(0);
  job.work->samples_before = 600;
  CHECK(job.samples_per_second(seconds(2)) == 100);
}

TEST_CASE("a limit of samples that nobody set is null, and the samples taken are known") {
  Job job = job_in_second_pass();
  json map = job_summary(job, seconds(1), "");
  CHECK(map.at("samples_per_pixel").is_null());
  CHECK(map.at("samples_taken") == 8);
  CHECK(map.at("has_picture") == true);
  job.record.settings->samples_per_pixel = 64;
  map = job_summary(job, seconds(1), "");
  CHECK(map.at("samples_per_pixel") == 64);
}

TEST_CASE("pauses do not count as time that a job has taken") {
  Job job;
  job.count_time(seconds(10), true);
  CHECK(job.seconds_taken(seconds(13)) == 3);
  job.count_time(seconds(15), false);
  CHECK(job.seconds_taken(seconds(99)) == 5);
  job.count_time(seconds(100), true);
  CHECK(job.seconds_taken(seconds(101)) == 6);
}

TEST_CASE("the report of a done job says what ended it, with and without an error") {
  Job job;
  job.record.state = JobState::done;
  CHECK_FALSE(job_summary(job, seconds(1), "").contains("ended_by"));
  for (const auto& [stopped, ended] : {std::pair{"samples", "samples"},
                                       {"passes", "samples"},
                                       {"error", "target_error"},
                                       {"half-width", "target_half_width"},
                                       {"time", "time_limit"}}) {
    job.record.report = json{{"stopped_by", stopped}, {"samples", 100}}.dump();
    job.read_report();
    const json map = job_summary(job, seconds(1), "");
    CHECK(map.at("ended_by") == ended);
    CHECK(map.at("error").at("rmse").is_null());
  }
}

TEST_CASE("without a start there are no times") {
  Job job;
  job.record.course.submitted = 1e9;
  const json map = job_summary(job, seconds(1), "");
  CHECK(map.at("submitted") == 1e9);
  for (const char* key : {"started", "finished", "seconds_taken"}) CHECK(map.at(key).is_null());
  CHECK(map.at("has_picture") == false);
}

}  // namespace
}  // namespace parray
