// The error of a job that a coordinator reports: while a job with a target runs, and afterwards.
#include <doctest/doctest.h>

#include "cli/farm/client.h"
#include "common/scene/settings.h"
#include "coordinator/jobs/report.h"
#include "coordinator/store/disk_store.h"
#include "tests/support/rooms.h"
#include "tests/support/service.h"
#include "tests/support/temporary_directory.h"

namespace parray::test {
namespace {

RenderSettings to_an_error() {
  RenderSettings settings = small_settings(small_scene());
  settings.samples_per_pixel = 1'000'000;
  settings.adaptive = true;
  settings.target_error = 0.004;
  return settings;
}

}  // namespace

TEST_CASE("a job with a target reports its error after each pass, and finally that of the report") {
  Service service;
  Hand hand(service, "a", 4);
  const JobId id = service.submit(small_scene(), to_an_error());
  std::vector<double> errors;
  while (service.state(id) != "done") {
    const JobStatus job = job_status(service.job(id));
    CHECK(job.target_error == 0.004);
    if (job.error.known() && (errors.empty() || errors.back() != job.error.high)) {
      CHECK(job.error.low < job.error.rmse);
      CHECK(job.error.rmse < job.error.high);
      errors.push_back(job.error.high);
    }
    work(service, {{&hand, honest}}, id, 1);
  }
  REQUIRE(errors.size() >= 2);
  CHECK(errors.front() > 0.004);
  CHECK(std::is_sorted(errors.rbegin(), errors.rend()));
  const nlohmann::json report = service.fetch(id).report;
  const JobStatus done = job_status(service.job(id));
  CHECK(done.error.rmse == report.at("error").at("rmse"));
  CHECK(done.error.high == report.at("error").at("high"));
  CHECK(done.error.high <= 0.004);
  CHECK(done.error.half_width_p99 == report.at("error").at("half_width_p99"));
}

TEST_CASE("a job with fixed samples reports the error of the part that is rendered") {
  Service service;
  Hand hand(service, "a", 4);
  RenderSettings settings = many_leases();
  settings.samples_per_pixel = 16;
  const JobId id = service.submit(small_scene(), settings);
  work(service, {{&hand, honest}}, id, 2);
  CHECK_FALSE(service.job(id).contains("error"));
  for (int looks = 0; looks < 50 && !service.job(id).contains("error_so_far"); ++looks) {
    service.turn(milliseconds(100));
    hand.beat();
  }
  const nlohmann::json part = service.job(id).at("error_so_far");
  CHECK(part.at("share") > 0);
  CHECK(part.at("share") < 1);
  CHECK(part.at("low") < part.at("rmse"));
  CHECK(part.at("rmse") < part.at("high"));
  work(service, {{&hand, honest}}, id);
  CHECK_FALSE(service.job(id).contains("error_so_far"));
  CHECK(job_status(service.job(id)).error.known());
}

TEST_CASE("a job without a target reports its error when it is done, also after a restart") {
  const TemporaryDirectory directory;
  DiskStore store(directory.path());
  Service service(service_options(), &store);
  Hand hand(service, "a", 4);
  const JobId id = service.submit(small_scene(), many_leases());
  CHECK_FALSE(service.job(id).contains("error"));
  CHECK_FALSE(service.job(id).contains("target_error"));
  work(service, {{&hand, honest}}, id);
  const ErrorFigures error = job_status(service.job(id)).error;
  CHECK(error.known());
  service.restart();
  CHECK(job_status(service.job(id)).error.rmse == error.rmse);
}

TEST_CASE(
    "a restart keeps all figures of an unfinished job's error, also if it is cancelled then") {
  const TemporaryDirectory directory;
  DiskStore store(directory.path());
  Service service(service_options(), &store);
  Hand hand(service, "a", 4);
  const JobId id = service.submit(small_scene(), to_an_error());
  while (!service.job(id).contains("error")) work(service, {{&hand, honest}}, id, 1);
  service.steer(id, msg::JobAction::pause);
  service.turn();
  const nlohmann::json before = service.job(id);
  REQUIRE(before.at("error").at("low").is_number());
  service.restart();
  CHECK(service.job(id).at("error") == before.at("error"));
  service.steer(id, msg::JobAction::cancel);
  service.turn();
  service.restart();
  CHECK(service.job(id).at("error") == before.at("error"));
}

TEST_CASE("a picture of one sample a pixel has no error, and says so") {
  Service service;
  Hand hand(service, "a", 4);
  RenderSettings settings = many_leases();
  settings.samples_per_pixel = 1;
  const JobId id = service.submit(small_scene(), settings);
  work(service, {{&hand, honest}}, id);
  CHECK(service.job(id).at("error").at("rmse").is_null());
}

TEST_CASE("an invalid error counts as unknown") {
  for (const char* text : {"", "null", "[]", "{", "{}", R"({"error": 1})", R"({"error": null})",
                           R"({"error": {"rmse": "0.1", "low": -1}})"}) {
    CHECK_FALSE(error_in(text).known());
  }
  CHECK(error_in(R"({"error": {"rmse": 0.5, "low": null}})").rmse == 0.5);
  CHECK(error_from_json(error_to_json({1, 0.5, 2, -1, 3})).half_width_p50 == -1);
  CHECK(error_from_json(error_to_json({1, 0.5, 2, -1, 3})).half_width_p99 == 3);
}

}  // namespace parray::test
