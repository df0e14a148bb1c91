// Tests that the coordinator finds faulty machines, and that they get no leases until their
// quarantine ends.
#include <doctest/doctest.h>

#include <memory>
#include <vector>

#include "common/scene/settings.h"
#include "tests/support/contains.h"
#include "tests/support/crash_store.h"
#include "tests/support/faulty_hands.h"
#include "tests/support/rooms.h"
#include "tests/support/service.h"

namespace parray::test {

TEST_CASE("two machines with the same wrong result do not outvote three correct ones") {
  Service service(with_checks(1));
  std::vector<std::unique_ptr<Hand>> machines;
  Hands hands;
  for (const char* name : {"faulty 1", "faulty 2", "ann", "bob", "cid"}) {
    machines.push_back(std::make_unique<Hand>(service, name));
    hands.emplace_back(machines.back().get(), contains(name, "faulty") ? lying : honest);
  }
  const RenderSettings settings = of_height(200);
  const JobId job = service.submit(small_scene(), settings);
  work(service, hands, job);
  check_right(service, job, settings, hands, "faulty");
  CHECK(service.worker("faulty 1").at("state") == "quarantined");
  CHECK(service.worker("faulty 2").at("state") == "quarantined");
}

TEST_CASE(
    "one correct machine among nine with the same wrong result: right bits, no quarantine for it") {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    CAPTURE(seed);
    CoordinatorOptions options = with_checks(1);
    options.random = [dice = std::make_shared<Dice>(seed)] { return dice->unit(); };
    Service service(options);
    std::vector<std::unique_ptr<Hand>> machines;
    Hands hands;
    for (int i = 0; i < 10; ++i) {
      const std::string name = i == 4 ? "ann" : "faulty " + std::to_string(i);
      machines.push_back(std::make_unique<Hand>(service, name));
      hands.emplace_back(machines.back().get(), i == 4 ? Manner(honest) : lying);
    }
    const RenderSettings settings = of_height(400);
    const JobId job = service.submit(small_scene(), settings);
    work(service, hands, job);
    check_right(service, job, settings, hands, "faulty");
  }
}

TEST_CASE("machines that are wrong rarely, late, first or second are found; correct ones are not") {
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    CAPTURE(seed);
    Service service(with_checks(1));
    Hand ann(service, "ann");
    Hand rare(service, "faulty, rarely");
    Hand late(service, "faulty, late");
    Hand always(service, "faulty, always");
    const Hands hands{{&ann, honest},
                      {&rare, lying_rarely(5, seed)},
                      {&late, seed % 2 == 0 ? Manner(honest) : lying},
                      {&always, lying}};
    const RenderSettings settings = of_height(300);
    const JobId job = service.submit(small_scene(), settings);
    work(service, {{&ann, honest}, {&late, honest}}, job, 5);
    work(service, hands, job);
    check_right(service, job, settings, hands, "faulty");
    CHECK(service.worker("faulty, always").at("state") == "quarantined");
  }
}

TEST_CASE(
    "a faulty worker that restarts under other names remains the same machine, in quarantine") {
  CrashStore store(0, 1);
  Service service(with_checks(1), &store);
  Hand ann(service, "ann", "10.0.0.1");
  Hand bob(service, "bob", "10.0.0.2");
  Hand faulty(service, "faulty", "10.0.0.3");
  const RenderSettings settings = of_height(300);
  const JobId job = service.submit(small_scene(), settings);
  const Hands hands{{&ann, honest}, {&bob, honest}, {&faulty, lying}};
  for (int life = 0; life < 8; ++life) {
    work(service, hands, job, 4);
    if (life == 4) {
      service.restart();
      ann.join();
      bob.join();
    }
    faulty.join_as("faulty " + std::to_string(life));
  }
  CHECK(service.worker(faulty.name()).at("state") == "quarantined");
  CHECK(service.worker(faulty.name()).at("machine") == "address 10.0.0.3");
  work(service, hands, job);
  check_right(service, job, settings, hands, "faulty");
}

TEST_CASE("a faulty worker that leaves after each result is checked nevertheless") {
  Service service(with_checks(1));
  Hand ann(service, "ann", "10.0.0.1");
  Hand faulty(service, "faulty", "10.0.0.3");
  const RenderSettings settings = of_height(200);
  const JobId job = service.submit(small_scene(), settings);
  int lives = 0;
  const Manner hit_and_run = [&](Hand& hand, const msg::Grant& grant) {
    hand.send_wrong(grant);
    hand.say(msg::Bye{"that was it"});
    hand.join_as("faulty " + std::to_string(++lives));
  };
  work(service, {{&ann, honest}, {&faulty, hit_and_run}}, job);
  REQUIRE(service.state(job) == "done");
  CHECK(service.sha256(job) == reference_sha256(small_scene(), settings));
  CHECK(service.worker(faulty.name()).at("state") == "quarantined");
}

TEST_CASE("two processes of one machine count as one: neither checks the other") {
  CoordinatorOptions options = with_checks(1);
  options.checks.referee_share = 0;
  options.referee = nullptr;
  Service service(options);
  Hand one(service, "one", "10.0.0.3");
  Hand two(service, "two", "10.0.0.3");
  const JobId job = service.submit(small_scene(), many_leases());
  work(service, {{&one, honest}, {&two, honest}}, job);
  REQUIRE(service.state(job) == "done");
  CHECK(service.fetch(job).report.at("checked_share") == 0);
  Hand other(service, "other", "10.0.0.4");
  const JobId next = service.submit(small_scene(), many_leases());
  work(service, {{&one, honest}, {&two, honest}, {&other, honest}}, next);
  CHECK(service.fetch(next).report.at("checked_share") == 1);
}

TEST_CASE("a machine that takes checks but never returns them blocks no job") {
  for (const bool drained : {true, false}) {
    CAPTURE(drained);
    CoordinatorOptions options = with_checks(1);
    options.checks.referee_share = 0;
    Service service(options);
    Hand ann(service, "ann");
    Hand bob(service, "bob");
    const JobId job = service.submit(small_scene(), many_leases());
    work(service, {{&ann, honest}, {&bob, idle}}, job, 60);
    if (drained) {
      service.ask<msg::Workers>(msg::SteerWorkers{1, msg::WorkerAction::drain, false, "bob"});
    }
    work(service, {{&ann, honest}, {&bob, idle}}, job, 400, milliseconds(500));
    CHECK(service.state(job) == "done");
  }
}

TEST_CASE("a quarantine of an address ends after a day, that of a key when it is readmitted") {
  double wall = 1e9;
  CoordinatorOptions options = with_checks(1);
  options.wall_clock = [&wall] { return wall; };
  Service service(options);
  Hand ann(service, "ann");
  Hand guest(service, "faulty at an address", "10.0.0.3");
  Hand node(service, "faulty with a key", 1, "here", {Role::worker, "node-1", 1, "10.0.0.4"});
  const RenderSettings settings = of_height(300);
  const JobId job = service.submit(small_scene(), settings);
  work(service, {{&ann, honest}, {&guest, lying}, {&node, lying}}, job);
  REQUIRE(service.worker(guest.name()).at("state") == "quarantined");
  REQUIRE(service.worker(node.name()).at("state") == "quarantined");
  CHECK(service.worker(guest.name()).at("quarantine_ends") == wall + 24 * 3600);
  CHECK(service.worker(node.name()).at("quarantine_ends") == 0);
  const auto wait_a_look = [&] {
    for (int i = 0; i < 30; ++i) {
      service.turn(milliseconds(500));
      ann.beat();
      guest.beat();
      node.beat();
    }
  };
  wall += 24 * 3600 - 1;
  wait_a_look();
  CHECK(service.worker(guest.name()).at("state") == "quarantined");
  wall += 2;
  wait_a_look();
  CHECK(service.worker(guest.name()).at("state") == "ready");
  CHECK(service.worker(node.name()).at("state") == "quarantined");
  service.ask<msg::Workers>(msg::SteerWorkers{1, msg::WorkerAction::readmit, false, "node-1"});
  CHECK(service.worker(node.name()).at("state") == "ready");
}

}  // namespace parray::test
