// Tests that waiting jobs, scenes and finished pictures stay within the coordinator's --memory.
#include <doctest/doctest.h>

#include "common/scene/settings.h"
#include "tests/support/contains.h"
#include "tests/support/crash_store.h"
#include "tests/support/memory.h"
#include "tests/support/rooms.h"
#include "tests/support/service.h"

namespace parray::test {
namespace {

RenderSettings huge() {
  RenderSettings settings = many_leases();
  settings.width = settings.height = 4096;
  return settings;
}

}  // namespace

TEST_CASE("1000 waiting jobs of 4096 x 4096 hold no pictures, before and after a restart") {
  CrashStore store(0, 1);
  CoordinatorOptions options = service_options();
  options.limits.user_jobs = options.limits.user_pixels = SIZE_MAX;
  Service service(options, &store);
  const std::uint64_t before = peak_address_space();
  REQUIRE(JobPicture::memory(huge()) > std::uint64_t{1} << 30);
  for (int i = 0; i < 1000; ++i) REQUIRE(service.submit(small_scene(), huge()) > 0);
  CHECK(peak_address_space() - before < std::uint64_t{256} << 20);
  service.restart();
  const auto jobs = service.ask<msg::Jobs>(msg::ListJobs{1}).jobs;
  CHECK(jobs.size() == 1000);
  CHECK(jobs.back().at("state") == "queued");
  CHECK(jobs.back().at("waits_for") == "a worker (none is connected)");
  CHECK(peak_address_space() - before < std::uint64_t{256} << 20);
}

TEST_CASE("a job that needs more memory than there is is refused at submit, with the figures") {
  CoordinatorOptions options = service_options();
  options.memory = std::uint64_t{1} << 30;
  Service service(options);
  const auto error = service.ask<msg::Error>(service.submission(small_scene(), huge()));
  CHECK(error.status == 2);
  CHECK(contains(error.message, "2854 MB"));
  CHECK(contains(error.message, "1074 MB"));
  CHECK(contains(error.message, "--memory"));
  CHECK(service.ask<msg::Jobs>(msg::ListJobs{1}).jobs.empty());
}

TEST_CASE("without a store, waiting scenes leave room for every job's picture, or are refused") {
  CoordinatorOptions options = service_options();
  Scene large = small_scene();
  for (int i = 0; i < 20'000; ++i) {  // 0.7 MB as it travels
    large.spheres.push_back({{100.0 + i % 100, 50.0 + i / 100, 30}, 0.1, 0});
  }
  options.memory = JobPicture::memory(many_leases()) + 3'000'000;
  Service service(options);
  std::vector<JobId> jobs;
  for (JobId job = 1; job > 0; jobs.push_back(job)) job = service.submit(large, many_leases());
  jobs.pop_back();
  CHECK(jobs.size() >= 2);
  CHECK(jobs.size() <= 4);
  const auto error = service.ask<msg::Error>(service.submission(large, many_leases()));
  CHECK(contains(error.message, "waiting scenes"));
  Hand ann(service, "ann");
  const auto trace = [&large](Hand& hand, const msg::Grant& grant) {
    hand.say(Hand::result(grant, Hand::trace(large, grant)));
  };
  for (const JobId job : jobs) {
    work(service, {{&ann, trace}}, job);
    CHECK(service.state(job) == "done");
  }
}

TEST_CASE("jobs beyond the memory wait for their turn, say so, and get it") {
  CoordinatorOptions options = service_options();
  options.memory = 2 * JobPicture::memory(many_leases()) + (1 << 16);
  CrashStore store(0, 1);
  Service service(options, &store);
  Hand ann(service, "ann", 16);
  std::vector<JobId> jobs;
  for (int i = 0; i < 4; ++i) jobs.push_back(service.submit(small_scene(), many_leases()));
  for (int round = 0; round < 5; ++round) {
    service.turn();
    ann.listen();
    for (const auto& [lease, grant] : ann.held) {
      CHECK((lease.first == jobs[0] || lease.first == jobs[1]));
    }
  }
  CHECK(service.job(jobs[3]).at("state") == "queued");
  work(service, {{&ann, honest}}, jobs[0]);
  work(service, {{&ann, honest}}, jobs[3]);
  for (const JobId job : jobs) {
    CHECK(service.sha256(job) == reference_sha256(small_scene(), many_leases()));
  }
}

TEST_CASE("a coordinator with less memory renders what fits, and a larger job says what it needs") {
  CrashStore store(0, 1);
  JobId large = 0;
  JobId small = 0;
  {
    Service before(service_options(), &store);
    large = before.submit(small_scene(), huge(), 90);
    small = before.submit(small_scene(), many_leases());
    before.turn();
  }
  CoordinatorOptions options = service_options();
  options.memory = std::uint64_t{1} << 29;
  Service service(options, &store);
  Hand ann(service, "ann");
  work(service, {{&ann, honest}}, small);
  CHECK(service.state(small) == "done");
  CHECK(service.state(large) == "queued");
  const std::string waits_for = service.job(large).at("waits_for");
  CHECK_MESSAGE(contains(waits_for, "and --memory is 0.500"), waits_for);
}

TEST_CASE("without a store, finished pictures make room for jobs: the oldest go") {
  RenderSettings settings = many_leases();
  settings.width = 250;
  settings.height = 200;
  settings.samples_per_pixel = 1;
  settings.max_depth = 2;
  CoordinatorOptions options = service_options();
  options.memory = JobPicture::memory(settings) + (1 << 16);
  SUBCASE("as many as fit with a job under way") { options.memory += 5'000'000; }
  SUBCASE("not even the last, where there is room for one job alone") {}
  Service service(options);
  Hand ann(service, "ann");
  std::vector<JobId> jobs;
  for (int i = 0; i < 9; ++i) {  // a picture has 1.4 MB
    jobs.push_back(service.submit(small_scene(), settings));
    work(service, {{&ann, honest}}, jobs.back());
    REQUIRE(service.state(jobs.back()) == "done");
    CHECK(service.sha256(jobs.back()) == service.fetch(jobs.back()).report.at("image_sha256"));
  }
  CHECK(contains(service.ask<msg::Error>(msg::Fetch{1, jobs[0]}).message, "no longer keeps"));
  CHECK(service.state(jobs[0]) == "done");
}

}  // namespace parray::test
