// A check covers all cells of a lease, although the referee traces only some of them.
#include <doctest/doctest.h>

#include <cstring>
#include <memory>
#include <string>

#include "common/scene/settings.h"
#include "tests/support/contains.h"
#include "tests/support/crash_store.h"
#include "tests/support/rooms.h"
#include "tests/support/service.h"

namespace parray::test {
namespace {

/// Returns options with which the referee takes part in every check. The constant random number
/// makes it trace cells in the middle of the lease.
CoordinatorOptions always_with_referee(double share = 1) {
  CoordinatorOptions options = service_options();
  options.checks.share = share;
  options.checks.referee_share = 1;
  options.random = [] { return 0.5; };
  return options;
}

/// Returns results that took so long that the referee has time for few cells of a lease. In the
/// wrong ones, the first cell is that of another picture.
Manner slow(bool lies) {
  return [lies](Hand& hand, const msg::Grant& grant) {
    TracedCells cells = Hand::trace(small_scene(), grant);
    if (lies) {
      msg::Grant other = grant;
      ++other.settings->seed;
      const TracedCells wrong = Hand::trace(small_scene(), other);
      const std::size_t first_cell = record_bytes(grant.cells.grid->shape().cell_pixels);
      std::memcpy(cells.records.data(), wrong.records.data(), first_cell);
    }
    msg::Result result = Hand::result(grant, std::move(cells));
    result.seconds = 10;
    hand.say(result);
  };
}

RenderSettings settings_with_long_leases() {
  RenderSettings settings = many_leases();
  settings.height = 200;
  return settings;
}

void steer(Service& service, msg::WorkerAction action, const Hand& hand) {
  service.ask<msg::Workers>(msg::SteerWorkers{1, action, false, hand.name()});
}

}  // namespace

TEST_CASE("a machine checks the cells of a lease that the referee leaves out") {
  const auto referee = std::make_shared<SimReferee>();
  CoordinatorOptions options = always_with_referee();
  options.referee = referee;
  Service service(options);
  Hand ann(service, "ann");
  Hand faulty(service, "faulty");
  const RenderSettings settings = settings_with_long_leases();
  const JobId job = service.submit(small_scene(), settings);
  work(service, {{&ann, slow(false)}, {&faulty, slow(false)}}, job, 1);
  work(service, {{&ann, slow(false)}, {&faulty, slow(true)}}, job);
  REQUIRE(service.state(job) == "done");
  CHECK(referee->asked > 0);
  CHECK(service.sha256(job) == expected_sha256(settings));
  CHECK(service.worker("faulty").at("state") == "quarantined");
  CHECK(service.worker("ann").at("state") == "ready");
}

TEST_CASE("if machines and the referee check all leases, every cell is checked, without a flag") {
  Service service(always_with_referee());
  Hand ann(service, "ann");
  Hand bob(service, "bob");
  const JobId job = service.submit(small_scene(), settings_with_long_leases());
  work(service, {{&ann, slow(false)}, {&bob, slow(false)}}, job);
  REQUIRE(service.state(job) == "done");
  CHECK(service.fetch(job).report.at("checked_share") == 1);
  CHECK(service.job(job).at("flag") == "");
}

TEST_CASE("a job says that the referee alone could not check all cells, if all must be checked") {
  for (const double share : {1.0, 0.6}) {
    CAPTURE(share);
    Service service(always_with_referee(share));
    Hand ann(service, "ann");
    const JobId job = service.submit(small_scene(), settings_with_long_leases());
    work(service, {{&ann, slow(false)}}, job);
    REQUIRE(service.state(job) == "done");
    const double checked = service.fetch(job).report.at("checked_share");
    CHECK(checked > 0);
    CHECK(checked < 1);
    CHECK(contains(service.job(job).at("flag"), "not checked completely") == (share == 1));
  }
}

TEST_CASE("a job says that the referee failed at checks that no machine could make") {
  const auto referee = std::make_shared<SimReferee>();
  referee->ailments.failure = "it was killed by signal 9";
  CoordinatorOptions options = always_with_referee(0.6);
  options.referee = referee;
  Service service(options);
  Hand ann(service, "ann");
  const JobId job = service.submit(small_scene(), settings_with_long_leases());
  work(service, {{&ann, slow(false)}}, job, 2000, milliseconds(500));
  REQUIRE(service.state(job) == "done");
  REQUIRE(referee->asked > 0);
  const std::string flag = service.job(job).at("flag");
  CHECK(contains(flag, "not checked completely"));
  CHECK(std::stoull(flag) == service.tally().accepted);
  Hand bob(service, "bob");
  const JobId next = service.submit(small_scene(), settings_with_long_leases());
  work(service, {{&ann, slow(false)}, {&bob, slow(false)}}, next, 2000, milliseconds(500));
  REQUIRE(service.state(next) == "done");
  CHECK(service.job(next).at("flag") == "");
}

TEST_CASE("a coordinator that was killed makes the checks that had waited") {
  for (const bool passes : {false, true}) {
    for (const int rounds : {1, 2, 5, 100}) {
      CAPTURE(passes);
      CAPTURE(rounds);
      CrashStore store(0, 1);
      CoordinatorOptions options = always_with_referee();
      options.checks.referee_share = 0;
      Service service(options, &store);
      Hand ann(service, "ann");
      Hand faulty(service, "faulty");
      const RenderSettings settings = passes ? in_passes() : settings_with_long_leases();
      const JobId job = service.submit(small_scene(), settings);
      work(service, {{&ann, idle}, {&faulty, slow(true)}}, job, rounds);
      REQUIRE(service.tally().accepted > 0);
      REQUIRE(service.state(job) == "running");
      store.crash();
      service.restart();
      for (int i = 0; i < 10; ++i) {
        service.turn();  // the workers are not back yet
      }
      ann.join();
      Hand bob(service, "bob");
      work(service, {{&ann, slow(false)}, {&bob, slow(false)}}, job);
      REQUIRE(service.state(job) == "done");
      CHECK(service.sha256(job) == expected_sha256(settings));
      CHECK(service.fetch(job).report.at("checked_share") == 1);
      CHECK(service.job(job).at("flag") != "");
    }
  }
}

TEST_CASE("a time limit counts after a restart in which only checks of a pass remained") {
  CrashStore store(0, 1);
  CoordinatorOptions options = always_with_referee();
  options.referee = nullptr;
  Service service(options, &store);
  Hand ann(service, "ann");
  Hand bob(service, "bob");
  RenderSettings settings = in_passes();
  settings.passes.clear();
  settings.samples_per_pixel = 100'000;
  settings.time_limit = 5;
  const JobId job = service.submit(small_scene(), settings);
  work(service, {{&ann, honest}, {&bob, idle}}, job, 20);
  REQUIRE(service.tally().accepted > 0);
  const auto samples = service.job(job).at("samples_taken").get<double>();
  store.crash();
  service.restart();
  ann.join();
  work(service, {{&ann, honest}}, job, 500, milliseconds(200));
  CHECK(service.job(job).at("samples_taken").get<double>() > samples);
  CHECK(service.job(job).at("ended_by") == "time_limit");
}

TEST_CASE("a coordinator that was killed makes the drawn checks that had waited, and no others") {
  for (const bool passes : {false, true}) {
    for (const int rounds : {2, 5, 100}) {
      CAPTURE(passes);
      CAPTURE(rounds);
      CrashStore store(0, 1);
      CoordinatorOptions options = service_options();
      options.checks.share = 0.5;
      options.checks.first_share = 0;
      options.checks.referee_share = 0;
      bool draws = false;
      options.random = [&draws] { return draws ? 0.2 : 0.9; };
      Service service(options, &store);
      Hand ann(service, "ann");
      const RenderSettings settings = passes ? in_passes() : settings_with_long_leases();
      const JobId job = service.submit(small_scene(), settings);
      work(service, {{&ann, slow(false)}}, job, 1);  // these are not drawn
      const std::uint64_t not_drawn = service.tally().accepted;
      REQUIRE(not_drawn > 0);
      draws = true;
      Hand faulty(service, "faulty");
      work(service, {{&ann, idle}, {&faulty, slow(true)}}, job, rounds);
      REQUIRE(service.tally().accepted > not_drawn);
      REQUIRE(service.state(job) == "running");
      draws = false;
      store.crash();
      service.restart();
      ann.join();
      Hand bob(service, "bob");
      work(service, {{&ann, slow(false)}, {&bob, slow(false)}}, job);
      REQUIRE(service.state(job) == "done");
      CHECK(service.sha256(job) == expected_sha256(settings));
      CHECK(service.fetch(job).report.at("checked_share") < 1);
    }
  }
}

TEST_CASE("a referee that may not check a large scene does not check it after a restart either") {
  const auto referee = std::make_shared<SimReferee>();
  CrashStore store(0, 1);
  CoordinatorOptions options = always_with_referee(0.9);
  options.referee = referee;
  options.checks.most_spheres = 1;
  Service service(options, &store);
  Hand ann(service, "ann");
  Hand bob(service, "bob");
  const Hands hands{{&ann, slow(false)}, {&bob, slow(false)}};
  const JobId job = service.submit(small_scene(), settings_with_long_leases());
  work(service, hands, job, 2);
  REQUIRE(service.tally().accepted > 0);
  REQUIRE(service.state(job) == "running");
  service.restart();
  ann.join();
  bob.join();
  work(service, hands, job);
  REQUIRE(service.state(job) == "done");
  CHECK(referee->asked == 0);
  CHECK(service.tally().duplicate > 0);
}

TEST_CASE("a check waits for the only other machine if that lost its lease in a pause") {
  for (const bool lies : {false, true}) {
    CAPTURE(lies);
    Service service(always_with_referee());
    Hand faulty(service, "faulty");
    Hand bob(service, "bob");
    const RenderSettings settings = settings_with_long_leases();
    const JobId job = service.submit(small_scene(), settings);
    work(service, {{&faulty, slow(lies)}, {&bob, idle}}, job, 20);
    work(service, {{&faulty, slow(lies)}}, job, 40, milliseconds(200));  // `bob` is silent
    REQUIRE(service.worker("bob").is_null());
    REQUIRE(service.tally().lost == 1);
    CHECK(service.state(job) == "running");
    bob.come_back();
    work(service, {{&faulty, slow(lies)}, {&bob, slow(false)}}, job);
    REQUIRE(service.state(job) == "done");
    CHECK(service.sha256(job) == expected_sha256(settings));
    const std::string flag = service.job(job).at("flag");
    CHECK(flag.empty() == !lies);
    CHECK_FALSE(contains(flag, "not checked completely"));
  }
}

namespace {

/// A job whose checks wait: `ann` traces, and `bob` takes no lease. There is no referee.
struct TwoMachines {
  explicit TwoMachines(int rounds) {
    work(service, {{&ann, slow(false)}, {&bob, idle}}, job, rounds);
  }
  static CoordinatorOptions options() {
    CoordinatorOptions options = always_with_referee();
    options.referee = nullptr;
    return options;
  }
  Service service{options()};
  Hand ann{service, "ann"};
  Hand bob{service, "bob"};
  JobId job = service.submit(small_scene(), settings_with_long_leases());
};

}  // namespace

TEST_CASE("a check waits only for a while for a machine that was lost, and not for one that left") {
  for (const bool lost : {true, false}) {
    CAPTURE(lost);
    TwoMachines machines(20);
    auto& [service, ann, bob, job] = machines;
    if (!lost) bob.say(msg::Bye{"in a test"});
    const Time began = service.now();
    work(service, {{&ann, slow(false)}}, job, 500, milliseconds(200));
    REQUIRE(service.state(job) == "done");
    CHECK(contains(service.job(job).at("flag"), "not checked completely"));
    CHECK((service.now() - began > seconds(20)) == lost);
  }
}

TEST_CASE("a check waits for a machine that gets leases again within a minute") {
  Service service(TwoMachines::options());
  Hand ann(service, "ann");
  Hand bob(service, "bob");
  const JobId job = service.submit(small_scene(), settings_with_long_leases());
  work(service, {{&bob, failing}}, job, 1);
  work(service, {{&ann, slow(false)}, {&bob, failing}}, job, 2);
  REQUIRE(service.worker("bob").at("state") == "backoff");
  work(service, {{&ann, slow(false)}, {&bob, slow(false)}}, job, 300, milliseconds(500));
  REQUIRE(service.state(job) == "done");
  CHECK(service.fetch(job).report.at("checked_share") == 1);
  CHECK(service.job(job).at("flag") == "");
}

TEST_CASE("a check waits for no machine that gets no leases for longer") {
  Service service(TwoMachines::options());
  Hand ann(service, "ann");
  Hand bob(service, "bob");
  const JobId job = service.submit(small_scene(), settings_with_long_leases());
  work(service, {{&bob, failing}}, job, 1);
  work(service, {{&ann, slow(false)}, {&bob, failing}}, job, 1000, milliseconds(500));
  REQUIRE(service.state(job) == "done");
  CHECK(service.worker("bob").at("backoff_seconds") > 60);
  CHECK(contains(service.job(job).at("flag"), "not checked completely"));
}

TEST_CASE("checks that wait for a machine go to another one when it is drained, or are left out") {
  for (const bool another : {false, true}) {
    CAPTURE(another);
    TwoMachines machines(60);
    auto& [service, ann, bob, job] = machines;
    REQUIRE(service.tally().duplicate == 0);
    REQUIRE(service.state(job) == "running");
    std::unique_ptr<Hand> cid = another ? std::make_unique<Hand>(service, "cid") : nullptr;
    steer(service, msg::WorkerAction::drain, bob);
    Hands hands{{&ann, slow(false)}, {&bob, idle}};
    if (another) hands.emplace_back(cid.get(), slow(false));
    work(service, hands, job, 500, milliseconds(200));
    REQUIRE(service.state(job) == "done");
    CHECK(contains(service.job(job).at("flag"), "not checked completely") != another);
    CHECK((service.fetch(job).report.at("checked_share") == 1) == another);
  }
}

TEST_CASE(
    "a machine that was lost and drained makes the waiting checks if it is readmitted in time") {
  for (const bool readmitted : {false, true}) {
    CAPTURE(readmitted);
    TwoMachines machines(20);
    auto& [service, ann, bob, job] = machines;
    work(service, {{&ann, slow(false)}}, job, 40, milliseconds(200));  // `bob` is silent
    REQUIRE(service.worker("bob").is_null());
    REQUIRE(service.state(job) == "running");
    steer(service, msg::WorkerAction::drain, bob);
    bob.come_back();
    const Hands hands{{&ann, slow(false)}, {&bob, slow(false)}};
    work(service, hands, job, 20);
    REQUIRE(service.state(job) == "running");
    REQUIRE(service.tally().duplicate == 0);
    if (readmitted) steer(service, msg::WorkerAction::readmit, bob);
    work(service, hands, job, 500, milliseconds(200));
    REQUIRE(service.state(job) == "done");
    const std::string flag = service.job(job).at("flag");
    CHECK(flag.empty() == readmitted);
    CHECK((service.fetch(job).report.at("checked_share") == 1) == readmitted);
  }
}

TEST_CASE("if a checker is faulty, another machine than the tracer checks all its cells again") {
  for (const bool late : {false, true}) {
    CAPTURE(late);  // it returns right checks first
    CoordinatorOptions options = service_options();
    options.checks.share = 1;
    options.checks.referee_share = 0;
    Service service(options);
    Hand ann(service, "ann");
    Hand bob(service, "bob");
    const RenderSettings settings = settings_with_long_leases();
    const JobId job = service.submit(small_scene(), settings);
    work(service, {{&ann, slow(false)}, {&bob, idle}}, job, 60);
    Hand faulty(service, "faulty");
    bob.say(msg::Bye{"in a test"});
    work(service, {{&ann, slow(false)}, {&faulty, slow(false)}}, job, late ? 2 : 0);
    REQUIRE(service.state(job) == "running");
    Hand cid(service, "cid");
    work(service, {{&ann, slow(false)}, {&faulty, slow(true)}, {&cid, slow(false)}}, job);
    REQUIRE(service.state(job) == "done");
    CHECK(service.worker("faulty").at("state") == "quarantined");
    CHECK(service.sha256(job) == expected_sha256(settings));
    CHECK(service.fetch(job).report.at("checked_share") == 1);
  }
}

}  // namespace parray::test
