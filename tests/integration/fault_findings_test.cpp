// A fault finding reaches jobs that were not running, were deciding a pass, or had all their cells.
#include <doctest/doctest.h>

#include <memory>
#include <string>

#include "common/scene/settings.h"
#include "tests/support/contains.h"
#include "tests/support/crash_store.h"
#include "tests/support/rooms.h"
#include "tests/support/service.h"

namespace parray::test {

TEST_CASE("results of a faulty worker are undone in a job that was not running at the finding") {
  enum class Case { waits, cancelled, readmitted };
  for (const bool passes : {false, true}) {
    const RenderSettings settings = passes ? in_passes() : many_leases();
    for (const Case which : {Case::waits, Case::cancelled, Case::readmitted}) {
      CAPTURE(passes);
      CAPTURE(static_cast<int>(which));
      CoordinatorOptions options = service_options();
      options.checks.share = 0.5;
      const auto drawn = std::make_shared<double>(0.9);  // no checks
      options.random = [drawn] { return *drawn; };
      CrashStore store(0, 1);
      Service service(options, &store);
      Hand faulty(service, "faulty");
      const JobId job = service.submit(small_scene(), settings, 10);
      work(service, {{&faulty, lying_loudly}}, job, 3);
      const bool waits = which == Case::waits;
      service.steer(job, waits ? msg::JobAction::pause : msg::JobAction::cancel);
      service.restart();

      *drawn = 0.2;  // all checks, none by the referee
      const JobId other = service.submit(small_scene(), many_leases(), 90);
      faulty.join();
      Hand ann(service, "ann");
      Hand bob(service, "bob");
      work(service, {{&faulty, lying_loudly}, {&ann, honest}, {&bob, honest}}, other);
      REQUIRE(service.worker("faulty").at("state") == "quarantined");
      if (which == Case::readmitted) {
        service.ask<msg::Workers>(
            msg::SteerWorkers{1, msg::WorkerAction::readmit, false, "faulty"});
      }
      service.restart();
      service.steer(job, waits ? msg::JobAction::resume : msg::JobAction::requeue);
      ann.join();
      bob.join();
      work(service, {{&ann, honest}, {&bob, honest}}, job);
      REQUIRE(service.state(job) == "done");
      CHECK(service.sha256(job) == expected_sha256(settings));
      CHECK(contains(service.job(job).at("flag"), "'faulty' returned wrong bits"));
    }
  }
}

TEST_CASE(
    "a job with all its cells ends after a fault finding, with or without cells to set back") {
  for (const bool passes : {false, true}) {
    for (const bool relies : {false, true}) {
      CAPTURE(passes);
      CAPTURE(relies);
      const RenderSettings settings = passes ? in_passes() : many_leases();
      CoordinatorOptions options = service_options();
      options.checks.share = 0.5;
      options.random = [] { return 0.2; };  // all checks, none by the referee
      CrashStore store(0, 1);
      Service service(options, &store);
      Hand ann(service, "ann");
      Hand other(service, "other");
      const JobId job = service.submit(small_scene(), settings);
      Hand& faulty = relies ? ann : other;
      Hand& waits = relies ? other : ann;
      for (int i = 0; i < 60; ++i) {  // all cells have arrived, except those being checked
        work(service, {{&ann, relies ? Manner(lying_loudly) : honest}, {&other, idle}}, job, 1);
        if (!other.held.empty()) other.put_down();
      }
      REQUIRE((passes || service.job(job).at("progress") == 1));
      REQUIRE(service.state(job) == "running");
      service.steer(job, msg::JobAction::cancel);
      const JobId next = service.submit(small_scene(), many_leases());
      waits.join();
      faulty.join();
      for (int i = 0; i < 5 && faulty.held.empty(); ++i) {
        service.turn();
        faulty.listen();
      }
      REQUIRE_FALSE(faulty.held.empty());
      faulty.send_forgery(faulty.put_down());
      service.turn();
      REQUIRE(service.worker(faulty.name()).at("state") == "quarantined");
      service.steer(next, msg::JobAction::cancel);
      service.steer(job, msg::JobAction::requeue);
      work(service, {{&waits, honest}}, job);
      REQUIRE(service.state(job) == "done");
      CHECK(service.sha256(job) == expected_sha256(settings));
      CHECK(contains(service.job(job).at("flag"), "returned wrong bits") == relies);
    }
  }
}

TEST_CASE("a fault finding while a job decides its next pass loses no pass of that job") {
  CrashStore store(0, 1);
  Service service(service_options(), &store);
  RenderSettings settings = in_passes();
  settings.schedule = SchedulePolicy::static_split;
  Hand ann(service, "ann");
  const JobId job = service.submit(small_scene(), settings);
  service.turn();
  Hand faulty(service, "faulty");
  service.turn();
  ann.listen();
  faulty.listen();
  const msg::Grant pass = ann.put_down();
  REQUIRE(pass.cells.range.count() == pass.cells.grid->cells());
  const msg::Grant copy = faulty.put_down();
  REQUIRE(copy.epoch == pass.epoch);
  ann.send_honest(pass);
  faulty.send_forgery(copy);
  service.turn();
  CHECK(service.worker("faulty").at("state") == "quarantined");
  store.crash();
  CHECK(store.jobs().front().passes.size() == 2);
  service.restart();
  ann.come_back();
  work(service, {{&ann, honest}}, job);
  CHECK(service.sha256(job) == expected_sha256(settings));
}

}  // namespace parray::test
