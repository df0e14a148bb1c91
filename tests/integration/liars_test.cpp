// Results are believed from holders only. Where two machines differ the referee decides.
#include <doctest/doctest.h>

#include <algorithm>
#include <memory>
#include <vector>

#include "common/scene/settings.h"
#include "tests/support/crash_store.h"
#include "tests/support/rooms.h"
#include "tests/support/service.h"

namespace parray::test {
namespace {

bool contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

CoordinatorOptions with_checks(double share) {
  CoordinatorOptions options = service_options();
  options.checks.share = share;
  return options;
}

void check_mended(Service& service, JobId job, const RenderSettings& settings) {
  REQUIRE(service.state(job) == "done");
  CHECK(service.sha256(job) == expected_sha256(settings));
  const auto report = service.fetch(job).report;
  CHECK(report.at("image_sha256") == service.sha256(job));
  CHECK(contains(report.at("flag"), "'liar'"));
  CHECK(contains(service.job(job).at("flag"), "'liar'"));
  CHECK(service.worker("liar").at("state") == "quarantined");
  CHECK(service.worker("liar").at("leases") == 0);
}

}  // namespace

TEST_CASE("a result for somebody else's lease is stale, before and after its holder's") {
  Service service;
  Hand ann(service, "ann");
  const JobId job = service.submit(small_scene(), many_leases());
  service.turn();
  ann.listen();
  const msg::Grant grant = ann.held.begin()->second;
  Hand thief(service, "thief");
  thief.send_lie(grant);
  service.turn();
  thief.listen();
  CHECK(thief.verdicts == std::vector<msg::Verdict>{msg::Verdict::stale});
  ann.send_honest(ann.put_down());
  service.turn();
  ann.listen();
  CHECK(ann.verdicts == std::vector<msg::Verdict>{msg::Verdict::accepted});
  thief.send_lie(grant);
  work(service, {{&ann, honest}, {&thief, honest}}, job);
  CHECK(service.sha256(job) == reference_sha256(small_scene(), many_leases()));
  CHECK(service.job(job).at("flag") == "");
  CHECK(service.worker("ann").at("state") == "ready");
}

TEST_CASE(
    "a result for an earlier coordinator, of which nothing was kept, is stale and convicts "
    "nobody") {
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

TEST_CASE("sums that nothing can have given convict who sends them, and are not merged") {
  Service service;
  Hand liar(service, "liar");
  const JobId job = service.submit(small_scene(), many_leases());
  service.turn();
  liar.listen();
  liar.send_forgery(liar.put_down());
  service.turn();
  CHECK(service.worker("liar").at("state") == "quarantined");
  CHECK(contains(service.worker("liar").at("reason"), "sums"));
  CHECK(service.job(job).at("progress") == 0);
  CHECK(service.job(job).at("waits_for") == "no worker whose results can be trusted");
  Hand ann(service, "ann");
  work(service, {{&ann, honest}, {&liar, lying}}, job);
  CHECK(service.sha256(job) == reference_sha256(small_scene(), many_leases()));
}

TEST_CASE("a result that was damaged on its way convicts nobody: its cells are traced again") {
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

TEST_CASE("of two machines that differ the referee decides, whoever came first") {
  for (const bool liar_first : {true, false}) {
    CAPTURE(liar_first);
    Service service(with_checks(1));
    Hand ann(service, liar_first ? "liar" : "ann");
    RenderSettings settings = many_leases();
    settings.height = 200;
    const JobId job = service.submit(small_scene(), settings);
    work(service, {{&ann, liar_first ? lying : honest}}, job, 3);
    Hand bob(service, liar_first ? "ann" : "liar");
    work(service, {{&ann, liar_first ? lying : honest}, {&bob, liar_first ? honest : lying}}, job);
    CHECK(service.worker("ann").at("state") == "ready");
    check_mended(service, job, settings);
  }
}

/// `ann` does everything but what the slow one and the liar hold, which do nothing, until it holds
/// a copy of the liar's lease, which is returned.
static msg::Grant work_until_copied(Service& service, Hand& slow, Hand& ann, Hand& liar) {
  std::optional<msg::Grant> lies;
  for (int round = 0; round < 200; ++round) {
    service.turn();
    for (Hand* hand : {&slow, &ann, &liar}) {
      hand->listen();
      hand->beat();
    }
    if (!liar.held.empty() && !lies) {
      lies = liar.held.begin()->second;
    }
    if (!ann.held.empty() && lies && ann.held.begin()->first.second == lies->epoch) {
      return *lies;
    }
    if (!ann.held.empty()) {
      ann.send_honest(ann.put_down());
    }
  }
  FAIL("no copy was made");
  return {};
}

TEST_CASE("the copies near the end are compared, too") {
  for (const bool liar_first : {true, false}) {
    CAPTURE(liar_first);
    Service service;
    Hand slow(service, "slow", 1);
    Hand ann(service, "ann");
    Hand liar(service, "liar");
    const JobId job = service.submit(small_scene(), many_leases());
    service.turn();
    const msg::Grant lies = work_until_copied(service, slow, ann, liar);
    const msg::Grant copy = ann.put_down();
    if (liar_first) {
      liar.send_lie(lies);
      service.turn();
      ann.send_honest(copy);
    } else {
      ann.send_honest(copy);
      service.turn();
      liar.send_lie(lies);
    }
    service.turn();
    CHECK(service.tally().mismatch == 1);
    work(service, {{&ann, honest}, {&slow, honest}, {&liar, idle}}, job);
    check_mended(service, job, many_leases());
  }
}

TEST_CASE("spot checks find a liar in the middle of a job, and all that it has done is undone") {
  for (const double share : {0.25, 0.5, 1.0}) {
    CAPTURE(share);
    Service service(with_checks(share));
    Hand ann(service, "ann");
    Hand bob(service, "bob");
    Hand liar(service, "liar");
    RenderSettings settings = many_leases();
    settings.height = 600;
    const JobId job = service.submit(small_scene(), settings);
    work(service, {{&ann, honest}, {&bob, honest}, {&liar, honest}}, job, 1);
    work(service, {{&ann, honest}, {&bob, honest}, {&liar, lying}}, job);
    check_mended(service, job, settings);
    CHECK(service.worker("ann").at("state") == "ready");
    CHECK(service.worker("bob").at("state") == "ready");
    CHECK(service.worker("liar").at("accepted") > 0);
  }
}

TEST_CASE("spot checks of honest workers cost time and nothing else") {
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

TEST_CASE("a job says how many checks could not be made") {
  CoordinatorOptions options = with_checks(1);
  options.referee = nullptr;
  Service service(options);
  Hand ann(service, "ann");
  const JobId job = service.submit(small_scene(), many_leases());
  work(service, {{&ann, honest}}, job);
  REQUIRE(service.state(job) == "done");
  CHECK(contains(service.job(job).at("flag"), "neither another machine nor the referee could"));
  CHECK(contains(service.fetch(job).report.at("flag"), "were to be checked"));
  CHECK(service.fetch(job).report.at("checked_share") == 0);
}

TEST_CASE("a picture in passes that a liar has touched is begun again, and is the honest one") {
  Service service(with_checks(1));
  Hand ann(service, "ann");
  Hand bob(service, "bob");
  Hand liar(service, "liar");
  const JobId job = service.submit(small_scene(), in_passes());
  work(service, {{&ann, honest}, {&bob, honest}, {&liar, honest}}, job, 12);
  work(service, {{&ann, honest}, {&bob, honest}, {&liar, lying}}, job);
  check_mended(service, job, in_passes());
  CHECK(service.fetch(job).report.at("passes") == in_passes().passes);
}

TEST_CASE("what was undone stays so when the coordinator dies at any moment afterwards") {
  for (const bool passes : {false, true}) {
    RenderSettings settings = passes ? in_passes() : many_leases();
    for (int rounds = 1; rounds < 40; rounds += 3) {
      CAPTURE(passes);
      CAPTURE(rounds);
      CrashStore store(0, 1);
      Service service(with_checks(1), &store);
      Hand ann(service, "ann");
      Hand bob(service, "bob");
      Hand liar(service, "liar");
      const JobId job = service.submit(small_scene(), settings);
      const Hands hands{{&ann, honest}, {&bob, honest}, {&liar, lying}};
      for (int i = 0; i < 100 && service.worker("liar").at("state") == "ready"; ++i) {
        work(service, hands, job, 1);
      }
      REQUIRE(service.worker("liar").at("state") == "quarantined");
      work(service, hands, job, rounds);
      store.crash();
      service.restart();
      ann.join();
      bob.join();
      work(service, {{&ann, honest}, {&bob, honest}}, job);
      REQUIRE(service.state(job) == "done");
      CHECK(service.sha256(job) == expected_sha256(settings));
      CHECK(contains(service.job(job).at("flag"), "'liar'"));
    }
  }
}

TEST_CASE("a liar is undone in every job that it has worked on, and gets no leases of any") {
  CoordinatorOptions options = with_checks(0.5);
  const auto drawn = std::make_shared<double>(0.9);  // no checks
  options.random = [drawn] { return *drawn; };
  Service service(options);
  Hand liar(service, "liar");
  const JobId first = service.submit(small_scene(), many_leases(), 90);
  work(service, {{&liar, lying}}, first, 3);
  RenderSettings other = many_leases();
  other.seed = 7;
  const JobId second = service.submit(small_scene(), other, 95);
  work(service, {{&liar, lying}}, second, 3);
  *drawn = 0.2;  // all checks, none by the referee
  Hand ann(service, "ann");
  Hand bob(service, "bob");
  const Hands hands{{&liar, lying}, {&ann, honest}, {&bob, honest}};
  work(service, hands, second);
  work(service, hands, first);
  check_mended(service, second, other);
  check_mended(service, first, many_leases());
}

namespace {

/// Nobody but these machines is in quarantine, and the picture is the honest one.
void check_right(Service& service, JobId job, const RenderSettings& settings, const Hands& hands,
                 const std::string& liars) {
  REQUIRE(service.state(job) == "done");
  CHECK(service.sha256(job) == reference_sha256(small_scene(), settings));
  for (const auto& [hand, manner] : hands) {
    CAPTURE(hand->name());
    const bool lies = contains(hand->name(), liars);
    CHECK((lies || service.worker(hand->name()).at("state") == "ready"));
  }
}

RenderSettings of_height(std::uint32_t height) {
  RenderSettings settings = many_leases();
  settings.height = height;
  return settings;
}

/// Lies in one of so many leases, the same lie as everybody's.
Manner lying_rarely(std::uint64_t one_in, std::uint64_t seed) {
  return [one_in, dice = std::make_shared<Dice>(seed)](Hand& hand, const msg::Grant& grant) {
    dice->one_in(one_in) ? hand.send_lie(grant) : hand.send_honest(grant);
  };
}

}  // namespace

TEST_CASE("two machines that tell the same lie do not outvote three honest ones") {
  Service service(with_checks(1));
  std::vector<std::unique_ptr<Hand>> machines;
  Hands hands;
  for (const char* name : {"liar 1", "liar 2", "ann", "bob", "cid"}) {
    machines.push_back(std::make_unique<Hand>(service, name));
    hands.emplace_back(machines.back().get(), contains(name, "liar") ? lying : honest);
  }
  const RenderSettings settings = of_height(200);
  const JobId job = service.submit(small_scene(), settings);
  work(service, hands, job);
  check_right(service, job, settings, hands, "liar");
  CHECK(service.worker("liar 1").at("state") == "quarantined");
  CHECK(service.worker("liar 2").at("state") == "quarantined");
}

TEST_CASE("one honest machine among nine that tell the same lie: right bits, and it stays") {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    CAPTURE(seed);
    CoordinatorOptions options = with_checks(1);
    options.random = [dice = std::make_shared<Dice>(seed)] { return dice->unit(); };
    Service service(options);
    std::vector<std::unique_ptr<Hand>> machines;
    Hands hands;
    for (int i = 0; i < 10; ++i) {
      const std::string name = i == 4 ? "ann" : "liar " + std::to_string(i);
      machines.push_back(std::make_unique<Hand>(service, name));
      hands.emplace_back(machines.back().get(), i == 4 ? Manner(honest) : lying);
    }
    const RenderSettings settings = of_height(400);
    const JobId job = service.submit(small_scene(), settings);
    work(service, hands, job);
    check_right(service, job, settings, hands, "liar");
  }
}

TEST_CASE("machines that lie rarely, late, first or second, are found; honest ones stay") {
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    CAPTURE(seed);
    Service service(with_checks(1));
    Hand ann(service, "ann");
    Hand rare(service, "liar, rarely");
    Hand late(service, "liar, late");
    Hand always(service, "liar, always");
    const Hands hands{{&ann, honest},
                      {&rare, lying_rarely(5, seed)},
                      {&late, seed % 2 == 0 ? Manner(honest) : lying},
                      {&always, lying}};
    const RenderSettings settings = of_height(300);
    const JobId job = service.submit(small_scene(), settings);
    work(service, {{&ann, honest}, {&late, honest}}, job, 5);
    work(service, hands, job);
    check_right(service, job, settings, hands, "liar");
    CHECK(service.worker("liar, always").at("state") == "quarantined");
  }
}

TEST_CASE("a liar that is started again under other names stays one machine, in quarantine") {
  CrashStore store(0, 1);
  Service service(with_checks(1), &store);
  Hand ann(service, "ann", "10.0.0.1");
  Hand bob(service, "bob", "10.0.0.2");
  Hand liar(service, "liar", "10.0.0.3");
  const RenderSettings settings = of_height(300);
  const JobId job = service.submit(small_scene(), settings);
  const Hands hands{{&ann, honest}, {&bob, honest}, {&liar, lying}};
  for (int life = 0; life < 8; ++life) {
    work(service, hands, job, 4);
    if (life == 4) {
      service.restart();
      ann.join();
      bob.join();
    }
    liar.join_as("liar " + std::to_string(life));
  }
  CHECK(service.worker(liar.name()).at("state") == "quarantined");
  CHECK(service.worker(liar.name()).at("machine") == "address 10.0.0.3");
  work(service, hands, job);
  check_right(service, job, settings, hands, "liar");
}

TEST_CASE("a liar that leaves after each result is checked all the same") {
  Service service(with_checks(1));
  Hand ann(service, "ann", "10.0.0.1");
  Hand liar(service, "liar", "10.0.0.3");
  const RenderSettings settings = of_height(200);
  const JobId job = service.submit(small_scene(), settings);
  int lives = 0;
  const Manner hit_and_run = [&](Hand& hand, const msg::Grant& grant) {
    hand.send_lie(grant);
    hand.say(msg::Bye{"that was it"});
    hand.join_as("liar " + std::to_string(++lives));
  };
  work(service, {{&ann, honest}, {&liar, hit_and_run}}, job);
  REQUIRE(service.state(job) == "done");
  CHECK(service.sha256(job) == reference_sha256(small_scene(), settings));
  CHECK(service.worker(liar.name()).at("state") == "quarantined");
}

TEST_CASE("two processes of one machine are one voice: neither checks the other") {
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

TEST_CASE("a machine that takes checks and never makes them holds up no job") {
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
    work(service, {{&ann, honest}, {&bob, idle}}, job, 200, milliseconds(500));
    CHECK(service.state(job) == "done");
  }
}

TEST_CASE("by default the referee finds the one machine of a farm when it always lies") {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    CAPTURE(seed);
    CoordinatorOptions options = with_checks(0.01);
    options.random = [dice = std::make_shared<Dice>(seed)] { return dice->unit(); };
    Service service(options);
    Hand liar(service, "liar", "10.0.0.3");
    // 0.9^100 is 3e-5: within its first 100 leases.
    while (service.worker("liar").at("accepted") < 100 &&
           service.worker("liar").at("state") == "ready") {
      work(service, {{&liar, lying}}, service.submit(small_scene(), many_leases()));
    }
    CHECK(service.worker("liar").at("state") == "quarantined");
  }
}

TEST_CASE("while the referee is dead or silent a disputed job is held, and nobody is judged") {
  for (const bool silent : {true, false}) {
    CAPTURE(silent);
    CoordinatorOptions options = with_checks(1);
    const auto referee = std::make_shared<SimReferee>();
    options.referee = referee;
    Service service(options);
    referee->ailments.silent = silent;
    referee->ailments.failure = silent ? "" : "it was killed by signal 9";
    Hand ann(service, "ann");
    Hand liar(service, "liar");
    const RenderSettings settings = of_height(200);
    const JobId job = service.submit(small_scene(), settings);
    const Hands hands{{&ann, honest}, {&liar, lying}};
    work(service, hands, job, 80, milliseconds(500));
    CHECK(service.state(job) == "paused");
    CHECK(contains(service.job(job).at("reason"), silent ? "not decided yet" : "signal 9"));
    CHECK(service.worker("ann").at("state") == "ready");
    CHECK(service.worker("liar").at("state") == "ready");
    referee->ailments = {};
    work(service, hands, job, 2000, milliseconds(500));  // a silent one is started again
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
  std::vector<std::unique_ptr<Hand>> liars;
  Hands hands{{&ann, honest}};
  for (int i = 0; i < 3; ++i) {
    liars.push_back(std::make_unique<Hand>(service, "liar " + std::to_string(i)));
    hands.emplace_back(liars.back().get(), lying);
  }
  const RenderSettings settings = of_height(200);
  const JobId job = service.submit(small_scene(), settings);
  bool held = false;
  for (int i = 0; i < 3000 && service.state(job) != "done"; ++i) {
    work(service, hands, job, 1, seconds(1));
    held = held || contains(service.job(job).at("reason"), "share of processor time");
  }
  CHECK(held);
  check_right(service, job, settings, hands, "liar");
}

TEST_CASE("a job is held where --memory leaves no room for the referee") {
  CoordinatorOptions options = with_checks(1);
  options.memory = std::uint64_t{32} << 20;
  Service service(options);
  Hand ann(service, "ann");
  Hand liar(service, "liar");
  const JobId job = service.submit(small_scene(), many_leases());
  work(service, {{&ann, honest}, {&liar, lying}}, job, 40);
  CHECK(service.state(job) == "paused");
  CHECK(contains(service.job(job).at("reason"), "--memory"));
  CHECK(service.worker("liar").at("state") == "ready");
}

TEST_CASE("nine machines that dispute everything open so many disputes and no more") {
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

TEST_CASE("a quarantine of an address ends after a day, that of a key when it is readmitted") {
  double wall = 1e9;
  CoordinatorOptions options = with_checks(1);
  options.wall_clock = [&wall] { return wall; };
  Service service(options);
  Hand ann(service, "ann");
  Hand guest(service, "liar at an address", "10.0.0.3");
  Hand node(service, "liar with a key", 1, "here", {Role::worker, "node-1", 1, "10.0.0.4"});
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
