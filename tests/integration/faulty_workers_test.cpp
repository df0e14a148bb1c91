// The coordinator accepts results only from holders of leases. If two machines differ, the referee
// decides.
#include <doctest/doctest.h>

#include <algorithm>
#include <memory>
#include <vector>

#include "common/scene/settings.h"
#include "tests/support/contains.h"
#include "tests/support/crash_store.h"
#include "tests/support/faulty_hands.h"
#include "tests/support/rooms.h"
#include "tests/support/service.h"

namespace parray::test {
namespace {

void check_mended(Service& service, JobId job, const RenderSettings& settings) {
  REQUIRE(service.state(job) == "done");
  CHECK(service.sha256(job) == expected_sha256(settings));
  const auto report = service.fetch(job).report;
  CHECK(report.at("image_sha256") == service.sha256(job));
  CHECK(contains(report.at("flag"), "'faulty'"));
  CHECK(contains(service.job(job).at("flag"), "'faulty'"));
  CHECK(service.worker("faulty").at("state") == "quarantined");
  CHECK(service.worker("faulty").at("leases") == 0);
}

}  // namespace

TEST_CASE("a result for another worker's lease is stale, before and after the holder's result") {
  Service service;
  Hand ann(service, "ann");
  const JobId job = service.submit(small_scene(), many_leases());
  service.turn();
  ann.listen();
  const msg::Grant grant = ann.held.begin()->second;
  Hand thief(service, "thief");
  thief.send_wrong(grant);
  service.turn();
  thief.listen();
  CHECK(thief.verdicts == std::vector<msg::Verdict>{msg::Verdict::stale});
  ann.send_honest(ann.put_down());
  service.turn();
  ann.listen();
  CHECK(ann.verdicts == std::vector<msg::Verdict>{msg::Verdict::accepted});
  thief.send_wrong(grant);
  work(service, {{&ann, honest}, {&thief, honest}}, job);
  CHECK(service.sha256(job) == reference_sha256(small_scene(), many_leases()));
  CHECK(service.job(job).at("flag") == "");
  CHECK(service.worker("ann").at("state") == "ready");
}

TEST_CASE("an exception of on_quarantine ends the coordinator") {
  CoordinatorOptions options = service_options();
  options.on_quarantine = [](const std::string& reason) { throw RunError(reason); };
  Service service(options);
  Hand liar(service, "liar");
  const JobId job = service.submit(small_scene(), many_leases());
  const auto forge = [](Hand& hand, const msg::Grant& grant) { hand.send_forgery(grant); };
  CHECK_THROWS_AS(work(service, {{&liar, forge}}, job), RunError);
}

TEST_CASE(
    "a result for an earlier coordinator without a state is stale, and its worker is not faulty") {
  Service service;
  Hand ann(service, "ann");
  RenderSettings others = many_leases();
  others.width += 5;
  service.submit(small_scene(), others);
  service.turn();
  ann.listen();
  const msg::Grant old = ann.put_down();
  service.restart();
  Hand again(service, "ann");  // the same process: its name and instance
  const JobId job = service.submit(small_scene(), many_leases());
  REQUIRE(job == old.job);
  service.turn();
  again.listen();
  REQUIRE_FALSE(again.held.empty());
  again.send_honest(old);
  service.turn();
  again.listen();
  CHECK(again.verdicts == std::vector<msg::Verdict>{msg::Verdict::stale});
  work(service, {{&again, honest}}, job);
  CHECK(service.sha256(job) == reference_sha256(small_scene(), many_leases()));
}

TEST_CASE("impossible sums are not merged, and their sender is faulty") {
  Service service;
  Hand faulty(service, "faulty");
  const JobId job = service.submit(small_scene(), many_leases());
  service.turn();
  faulty.listen();
  faulty.send_forgery(faulty.put_down());
  service.turn();
  CHECK(service.worker("faulty").at("state") == "quarantined");
  CHECK(contains(service.worker("faulty").at("reason"), "sums"));
  CHECK(service.job(job).at("progress") == 0);
  CHECK(service.job(job).at("waits_for") ==
        "a worker (all are drained or in quarantine: see parray workers, then readmit one)");
  Hand ann(service, "ann");
  work(service, {{&ann, honest}, {&faulty, lying}}, job);
  CHECK(service.sha256(job) == reference_sha256(small_scene(), many_leases()));
}

TEST_CASE(
    "a result damaged by the network makes no worker faulty, and its cells are traced again") {
  Service service;
  Hand ann(service, "ann");
  const JobId job = service.submit(small_scene(), many_leases());
  service.turn();
  ann.listen();
  const msg::Grant grant = ann.put_down();
  Frames frames = encode(Hand::result(grant, Hand::trace(small_scene(), grant)));
  std::string bulk(frames[1].view());
  bulk.back() = static_cast<char>(bulk.back() ^ 1);
  frames[1] = std::move(bulk);
  service.say_frames(ann.peer(), frames);
  service.turn();
  CHECK(service.worker("ann").at("state") == "ready");
  work(service, {{&ann, honest}}, job);
  CHECK(service.sha256(job) == reference_sha256(small_scene(), many_leases()));
}

TEST_CASE("if two machines differ, the referee decides, whichever came first") {
  for (const bool faulty_first : {true, false}) {
    CAPTURE(faulty_first);
    Service service(with_checks(1));
    RenderSettings settings = many_leases();
    settings.height = 200;
    const JobId job = service.submit(small_scene(), settings);
    Hand first(service, faulty_first ? "faulty" : "ann");
    work(service, {{&first, faulty_first ? lying : honest}}, job, 3);
    Hand second(service, faulty_first ? "ann" : "faulty");
    // A faulty machine that came first does nothing more: it does not check the correct one.
    work(service,
         {{&first, faulty_first ? idle : honest}, {&second, faulty_first ? honest : lying}}, job);
    CHECK(service.worker("ann").at("state") == "ready");
    check_mended(service, job, settings);
  }
}

/// Lets `ann` trace everything except the leases of the slow and the faulty worker, which do
/// nothing. Returns the copy of the faulty worker's lease when `ann` gets it.
static msg::Grant work_until_copied(Service& service, Hand& slow, Hand& ann, Hand& faulty) {
  std::optional<msg::Grant> lies;
  for (int round = 0; round < 200; ++round) {
    service.turn();
    for (Hand* hand : {&slow, &ann, &faulty}) {
      hand->listen();
      hand->beat();
    }
    if (!faulty.held.empty() && !lies) lies = faulty.held.begin()->second;
    if (!ann.held.empty() && lies && ann.held.begin()->first.second == lies->epoch) return *lies;
    if (!ann.held.empty()) ann.send_honest(ann.put_down());
  }
  FAIL("no copy was made");
  return {};
}

TEST_CASE("the copies near the end are compared, too") {
  for (const bool faulty_first : {true, false}) {
    CAPTURE(faulty_first);
    Service service;
    Hand slow(service, "slow", 1);
    Hand ann(service, "ann");
    Hand faulty(service, "faulty");
    const JobId job = service.submit(small_scene(), many_leases());
    service.turn();
    const msg::Grant lies = work_until_copied(service, slow, ann, faulty);
    const msg::Grant copy = ann.put_down();
    if (faulty_first) {
      faulty.send_wrong(lies);
      service.turn();
      ann.send_honest(copy);
    } else {
      ann.send_honest(copy);
      service.turn();
      faulty.send_wrong(lies);
    }
    service.turn();
    CHECK(service.tally().mismatch == 1);
    work(service, {{&ann, honest}, {&slow, honest}, {&faulty, idle}}, job);
    check_mended(service, job, many_leases());
  }
}

TEST_CASE(
    "spot checks find a faulty worker in the middle of a job, and all its results are undone") {
  for (const double share : {0.25, 0.5, 1.0}) {
    CAPTURE(share);
    Service service(with_checks(share));
    Hand ann(service, "ann");
    Hand bob(service, "bob");
    Hand faulty(service, "faulty");
    RenderSettings settings = many_leases();
    settings.height = 600;
    const JobId job = service.submit(small_scene(), settings);
    work(service, {{&ann, honest}, {&bob, honest}, {&faulty, honest}}, job, 1);
    work(service, {{&ann, honest}, {&bob, honest}, {&faulty, lying}}, job);
    check_mended(service, job, settings);
    CHECK(service.worker("ann").at("state") == "ready");
    CHECK(service.worker("bob").at("state") == "ready");
    CHECK(service.worker("faulty").at("accepted") > 0);
  }
}

TEST_CASE("spot checks of correct workers cost only time") {
  Service service(with_checks(1));
  Hand ann(service, "ann");
  Hand bob(service, "bob");
  const JobId job = service.submit(small_scene(), many_leases());
  work(service, {{&ann, honest}, {&bob, honest}}, job);
  CHECK(service.tally().duplicate > 0);
  CHECK(service.tally().mismatch == 0);
  CHECK(service.job(job).at("flag") == "");
  CHECK(service.sha256(job) == reference_sha256(small_scene(), many_leases()));
}

TEST_CASE("a job states the number of checks that were impossible") {
  CoordinatorOptions options = with_checks(1);
  options.referee = nullptr;
  Service service(options);
  Hand ann(service, "ann");
  const JobId job = service.submit(small_scene(), many_leases());
  work(service, {{&ann, honest}}, job);
  REQUIRE(service.state(job) == "done");
  CHECK(contains(service.job(job).at("flag"), "neither another machine nor the referee could"));
  CHECK(contains(service.fetch(job).report.at("flag"), "were not checked"));
  CHECK(service.fetch(job).report.at("checked_share") == 0);
}

TEST_CASE("a picture in passes with results of a faulty worker begins again, and is right") {
  Service service(with_checks(1));
  Hand ann(service, "ann");
  Hand bob(service, "bob");
  Hand faulty(service, "faulty");
  const JobId job = service.submit(small_scene(), in_passes());
  work(service, {{&ann, honest}, {&bob, honest}, {&faulty, honest}}, job, 12);
  work(service, {{&ann, honest}, {&bob, honest}, {&faulty, lying}}, job);
  check_mended(service, job, in_passes());
  CHECK(service.fetch(job).report.at("passes") == in_passes().passes);
}

TEST_CASE("undone results remain undone if the coordinator is killed at any later moment") {
  for (const bool passes : {false, true}) {
    RenderSettings settings = passes ? in_passes() : many_leases();
    for (int rounds = 1; rounds < 40; rounds += 3) {
      CAPTURE(passes);
      CAPTURE(rounds);
      CrashStore store(0, 1);
      Service service(with_checks(1), &store);
      Hand ann(service, "ann");
      Hand bob(service, "bob");
      Hand faulty(service, "faulty");
      const JobId job = service.submit(small_scene(), settings);
      const Hands hands{{&ann, honest}, {&bob, honest}, {&faulty, lying}};
      for (int i = 0; i < 100 && service.worker("faulty").at("state") == "ready"; ++i) {
        work(service, hands, job, 1);
      }
      REQUIRE(service.worker("faulty").at("state") == "quarantined");
      work(service, hands, job, rounds);
      store.crash();
      service.restart();
      ann.join();
      bob.join();
      work(service, {{&ann, honest}, {&bob, honest}}, job);
      REQUIRE(service.state(job) == "done");
      CHECK(service.sha256(job) == expected_sha256(settings));
      CHECK(contains(service.job(job).at("flag"), "'faulty'"));
    }
  }
}

TEST_CASE("a faulty worker's results are undone in all its jobs, and it gets no leases of any") {
  CoordinatorOptions options = with_checks(0.5);
  const auto drawn = std::make_shared<double>(0.9);  // no checks
  options.random = [drawn] { return *drawn; };
  Service service(options);
  Hand faulty(service, "faulty");
  const JobId first = service.submit(small_scene(), many_leases(), 90);
  work(service, {{&faulty, lying}}, first, 3);
  RenderSettings other = many_leases();
  other.seed = 7;
  const JobId second = service.submit(small_scene(), other, 95);
  work(service, {{&faulty, lying}}, second, 3);
  *drawn = 0.2;  // all checks, none by the referee
  Hand ann(service, "ann");
  Hand bob(service, "bob");
  const Hands hands{{&faulty, lying}, {&ann, honest}, {&bob, honest}};
  work(service, hands, second);
  work(service, hands, first);
  check_mended(service, second, other);
  check_mended(service, first, many_leases());
}

TEST_CASE("by default the referee finds the only machine of a farm if it is always wrong") {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    CAPTURE(seed);
    CoordinatorOptions options = with_checks(0.01);
    options.random = [dice = std::make_shared<Dice>(seed)] { return dice->unit(); };
    Service service(options);
    Hand faulty(service, "faulty", "10.0.0.3");
    // 0.9^100 is 3e-5: within its first 100 leases.
    while (service.worker("faulty").at("accepted") < 100 &&
           service.worker("faulty").at("state") == "ready") {
      work(service, {{&faulty, lying}}, service.submit(small_scene(), many_leases()));
    }
    CHECK(service.worker("faulty").at("state") == "quarantined");
  }
}

TEST_CASE("while the referee is dead or silent, a disputed job waits, and no machine is judged") {
  for (const bool silent : {true, false}) {
    CAPTURE(silent);
    CoordinatorOptions options = with_checks(1);
    const auto referee = std::make_shared<SimReferee>();
    options.referee = referee;
    Service service(options);
    referee->ailments.silent = silent;
    referee->ailments.failure = silent ? "" : "it was killed by signal 9";
    Hand ann(service, "ann");
    Hand faulty(service, "faulty");
    const RenderSettings settings = of_height(200);
    const JobId job = service.submit(small_scene(), settings);
    const Hands hands{{&ann, honest}, {&faulty, lying}};
    work(service, hands, job, 80, milliseconds(500));
    CHECK(service.state(job) == "paused");
    CHECK(contains(service.job(job).at("reason"), silent ? "not decided yet" : "signal 9"));
    CHECK(service.worker("ann").at("state") == "ready");
    CHECK(service.worker("faulty").at("state") == "ready");
    referee->ailments = {};
    work(service, hands, job, 2000, milliseconds(500));  // a silent referee is started again
    CHECK(service.worker("ann").at("state") == "ready");
    check_mended(service, job, settings);
  }
}

TEST_CASE("a job waits while the referee has used up its share of processor time") {
  CoordinatorOptions options = with_checks(1);
  options.checks.referee_share = 0;
  const auto referee = std::make_shared<SimReferee>();
  referee->ailments.seconds = 33;
  options.referee = referee;
  Service service(options);
  Hand ann(service, "ann");
  std::vector<std::unique_ptr<Hand>> faulty_workers;
  Hands hands{{&ann, honest}};
  for (int i = 0; i < 3; ++i) {
    faulty_workers.push_back(std::make_unique<Hand>(service, "faulty " + std::to_string(i)));
    hands.emplace_back(faulty_workers.back().get(), lying);
  }
  const RenderSettings settings = of_height(200);
  const JobId job = service.submit(small_scene(), settings);
  bool held = false;
  for (int i = 0; i < 3000 && service.state(job) != "done"; ++i) {
    work(service, hands, job, 1, seconds(1));
    held = held || contains(service.job(job).at("reason"), "share of processor time");
  }
  CHECK(held);
  check_right(service, job, settings, hands, "faulty");
}

TEST_CASE("a job waits if --memory leaves no room for the referee") {
  CoordinatorOptions options = with_checks(1);
  options.memory = std::uint64_t{32} << 20;
  Service service(options);
  Hand ann(service, "ann");
  Hand faulty(service, "faulty");
  const JobId job = service.submit(small_scene(), many_leases());
  work(service, {{&ann, honest}, {&faulty, lying}}, job, 40);
  CHECK(service.state(job) == "paused");
  CHECK(contains(service.job(job).at("reason"), "--memory"));
  CHECK(service.worker("faulty").at("state") == "ready");
}

TEST_CASE("nine machines that dispute everything open only a limited number of disputes") {
  CoordinatorOptions options = with_checks(1);
  options.checks.referee_share = 0;
  options.refereeing.most_disputes = 5;
  const auto referee = std::make_shared<SimReferee>();
  referee->ailments.silent = true;
  options.referee = referee;
  Service service(options);
  std::vector<std::unique_ptr<Hand>> machines;
  Hands hands;
  for (int i = 0; i < 10; ++i) {
    machines.push_back(std::make_unique<Hand>(service, "machine " + std::to_string(i), 4));
    hands.emplace_back(machines.back().get(), lying_rarely(2, static_cast<std::uint64_t>(i)));
  }
  const RenderSettings settings = of_height(600);
  const JobId job = service.submit(small_scene(), settings);
  work(service, hands, job, 60);
  CHECK(service.tally().mismatch > 5);
  CHECK(contains(service.job(job).at("reason"), "5 disputes are open"));
  CHECK(referee->asked == 1);
  CHECK(service.ask<msg::Workers>(msg::ListWorkers{1}).workers.size() == 10);
}

}  // namespace parray::test
