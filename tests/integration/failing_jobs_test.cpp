// A job that cannot be traced fails, and harms no other job.
#include <doctest/doctest.h>

#include <memory>
#include <string>
#include <vector>

#include "common/scene/settings.h"
#include "tests/support/contains.h"
#include "tests/support/crash_store.h"
#include "tests/support/rooms.h"
#include "tests/support/service.h"

namespace parray::test {
namespace {

/// Fails at one job, and traces others.
Manner failing_at(JobId job) {
  return [job](Hand& hand, const msg::Grant& grant) {
    grant.job == job ? hand.send_failure(grant) : hand.send_honest(grant);
  };
}

}  // namespace

TEST_CASE("a job that three workers cannot trace fails with the reason, and others continue") {
  Service service;
  Hand ann(service, "ann");
  Hand bob(service, "bob");
  Hand cid(service, "cid");
  const JobId bad = service.submit(small_scene(), many_leases(), 90);
  const JobId good = service.submit(small_scene(), many_leases());
  const Manner manner = failing_at(bad);
  work(service, {{&ann, manner}, {&bob, manner}, {&cid, manner}}, bad, 1000);
  CHECK(service.state(bad) == "failed");
  const std::string reason = service.job(bad).at("reason");
  CHECK(contains(reason, "not enough memory"));
  CHECK(contains(reason, "3 machines"));
  CHECK(service.state(good) != "failed");
  work(service, {{&ann, honest}, {&bob, honest}, {&cid, honest}}, good);
  CHECK(service.sha256(good) == reference_sha256(small_scene(), many_leases()));
  CHECK(service.worker("ann").at("state") == "ready");
}

TEST_CASE("a list of a thousand jobs with the longest reasons fits into a message") {
  CoordinatorOptions options = service_options();
  options.max_failures = 1;
  Service service(options);
  Hand ann(service, "ann");
  const std::string reason(2000, '\x01');
  std::vector<JobId> ids;
  for (int i = 0; i < 1000; ++i) {
    ids.push_back(service.submit(small_scene(), many_leases()));
    work(service,
         {{&ann,
           [&](Hand& hand, const msg::Grant& grant) {
             hand.say(msg::Failed{grant.job, grant.epoch, reason});
           }}},
         ids.back());
    REQUIRE(service.state(ids.back()) == "failed");
  }
  CHECK(service.ask<msg::Jobs>(msg::ListJobs{1}).jobs.size() == 1000);
  CHECK(service.ask<msg::Jobs>(msg::ListJobs{1, 0, 1}).jobs.at(0).at("reason") ==
        service.job(ids.back()).at("reason"));
}

TEST_CASE("with fewer workers, a job fails when each has failed twice at the same cells") {
  for (const int workers : {1, 2}) {
    CAPTURE(workers);
    Service service;
    Hand ann(service, "ann");
    Hands hands{{&ann, failing}};
    std::unique_ptr<Hand> bob;
    if (workers == 2) {
      bob = std::make_unique<Hand>(service, "bob");
      hands.emplace_back(bob.get(), failing);
    }
    const JobId job = service.submit(small_scene(), many_leases());
    work(service, hands, job, 1000);
    CHECK(service.state(job) == "failed");
    CHECK(service.tally().failed >= static_cast<std::uint64_t>(2 * workers));
    CHECK(contains(service.job(job).at("reason"), "twice"));
  }
}

TEST_CASE("workers that fail at the same time, each at other cells, also fail the job") {
  for (const auto policy : {SchedulePolicy::weighted, SchedulePolicy::guided}) {
    Service service;
    Hand ann(service, "ann");
    Hand bob(service, "bob");
    Hand cid(service, "cid");
    RenderSettings settings = many_leases();
    settings.schedule = policy;
    const JobId job = service.submit(small_scene(), settings);
    work(service, {{&ann, failing}, {&bob, failing}, {&cid, failing}}, job, 1000);
    CHECK(service.state(job) == "failed");
  }
}

TEST_CASE("a worker that can trace nothing fails no job, because the others trace it") {
  Service service;
  Hand ann(service, "ann");
  Hand bob(service, "bob");
  const JobId job = service.submit(small_scene(), many_leases());
  work(service, {{&ann, failing}, {&bob, honest}}, job);
  CHECK(service.tally().failed > 0);
  CHECK(service.sha256(job) == reference_sha256(small_scene(), many_leases()));
}

TEST_CASE("three faulty machines that answer first fail no job that six good ones can trace") {
  Service service;
  std::vector<std::unique_ptr<Hand>> all;
  Hands hands;
  for (int i = 0; i < 9; ++i) {
    all.push_back(std::make_unique<Hand>(service, "worker " + std::to_string(i)));
    hands.emplace_back(all.back().get(), i < 3 ? Manner(failing) : Manner(honest));
  }
  std::vector<JobId> jobs;
  for (int i = 0; i < 3; ++i) {
    jobs.push_back(service.submit(small_scene(), many_leases()));
    // The good workers have answered nothing yet.
    for (int round = 0; round < 4; ++round) {
      service.turn(milliseconds(10));
      for (int sick = 0; sick < 3; ++sick) {
        Hand& hand = *all[static_cast<std::size_t>(sick)];
        hand.listen();
        hand.beat();
        if (!hand.held.empty()) hand.send_failure(hand.put_down());
      }
    }
    work(service, hands, jobs.back());
    CHECK(service.state(jobs.back()) == "done");
  }
  for (int i = 0; i < 3; ++i) {
    const auto sick = service.worker("worker " + std::to_string(i));
    CHECK(sick.at("state") == "backoff");
    CHECK(sick.at("backoff_seconds") > 0);
    CHECK(sick.at("backoff_seconds") <= 60);
  }
  CHECK(service.worker("worker 5").at("state") == "ready");
  const std::uint64_t failed = service.tally().failed;
  const JobId next = service.submit(small_scene(), many_leases());
  work(service, hands, next);
  CHECK(service.state(next) == "done");
  CHECK(service.tally().failed == failed);  // they had no leases
}

TEST_CASE("a failing machine gets leases again after a minute, or when it is readmitted") {
  for (const bool readmitted : {false, true}) {
    CAPTURE(readmitted);
    CoordinatorOptions options = service_options();
    options.silence = seconds(500);
    options.lease_timeout = seconds(500);
    Service service(options);
    Hand ann(service, "ann");
    Hand bob(service, "bob");
    const JobId job = service.submit(small_scene(), many_leases());
    work(service, {{&ann, failing}, {&bob, honest}}, job);
    REQUIRE(service.state(job) == "done");
    REQUIRE(service.worker("ann").at("state") == "backoff");
    const JobId next = service.submit(small_scene(), many_leases());
    if (readmitted) {
      service.ask<msg::Workers>(msg::SteerWorkers{1, msg::WorkerAction::readmit, false, "ann"});
    } else {
      service.turn(seconds(61));
    }
    service.turn(seconds(1));
    CHECK(service.worker("ann").at("state") == "ready");
    work(service, {{&ann, honest}}, next);
    CHECK(service.state(next) == "done");
  }
}

TEST_CASE("a machine whose worker dies with every lease, each time with a new name, fails no job") {
  Service service;
  Hand healthy(service, "healthy");
  const JobId job = service.submit(small_scene(), many_leases());
  std::unique_ptr<Hand> dying;
  int lives = 0;
  for (int second = 0; second < 40; ++second) {
    if (!dying) dying = std::make_unique<Hand>(service, "vm-" + std::to_string(++lives), 1, "sick");
    service.turn(seconds(1));
    dying->listen();
    dying->beat();
    if (!dying->held.empty()) {
      dying.reset();  // never sends again
    }
    healthy.listen();
    healthy.beat();
    REQUIRE(service.state(job) != "failed");
  }
  work(service, {{&healthy, honest}}, job);
  CHECK(service.state(job) == "done");
}

TEST_CASE(
    "a worker that has failed at a job gets leases of another, and of the first one only later") {
  Service service;
  Hand ann(service, "ann");
  const JobId bad = service.submit(small_scene(), many_leases(), 90);
  const JobId good = service.submit(small_scene(), many_leases());
  service.turn();
  ann.listen();
  REQUIRE(ann.held.begin()->first.first == bad);
  ann.send_failure(ann.put_down());
  service.turn();
  ann.listen();
  REQUIRE(ann.held.size() == 1);
  CHECK(ann.held.begin()->first.first == good);
  ann.send_honest(ann.put_down());
  service.turn(seconds(2));
  ann.listen();
  REQUIRE(ann.held.size() == 1);
  CHECK(ann.held.begin()->first.first == bad);
}

TEST_CASE("two workers that fail shortly after each other are both asked again, each in its time") {
  Service service;
  Hand ann(service, "ann");
  RenderSettings one_lease = many_leases();
  one_lease.height = 1;
  service.submit(small_scene(), one_lease);
  service.turn();
  ann.listen();
  REQUIRE(ann.held.size() == 1);
  ann.send_failure(ann.put_down());
  service.turn(milliseconds(500));
  Hand bob(service, "bob");
  service.turn();
  bob.listen();
  REQUIRE(bob.held.size() == 1);
  bob.send_failure(bob.put_down());
  for (int i = 0; i < 6 && ann.held.empty(); ++i) {
    service.turn(milliseconds(100));
    ann.listen();
  }
  REQUIRE(ann.held.size() == 1);
  ann.say(msg::Bye{"ann leaves before it is bob's time"});
  for (int i = 0; i < 20 && bob.held.empty(); ++i) {
    service.turn(milliseconds(100));
    bob.listen();
    bob.beat();
  }
  CHECK(bob.held.size() == 1);
}

TEST_CASE("a scene that crashes its workers fails, although they start again each time") {
  Service service;
  Hand ann(service, "ann");
  Hand bob(service, "bob");
  Hand cid(service, "cid");
  const JobId bad = service.submit(small_scene(), many_leases(), 90);
  int seconds_passed = 0;
  for (; service.state(bad) != "failed" && seconds_passed < 100; ++seconds_passed) {
    service.turn(seconds(1));
    for (Hand* hand : {&ann, &bob, &cid}) {
      hand->listen();
      hand->beat();
      if (!hand->held.empty()) {
        service.turn(Time(0));
        hand->join();
      }
    }
  }
  CHECK(service.state(bad) == "failed");
  CHECK(seconds_passed < 30);
  CHECK(contains(service.job(bad).at("reason"), "lost while it traced"));
  service.turn(seconds(6));
  const JobId good = service.submit(small_scene(), many_leases());
  ann.join();
  work(service, {{&ann, honest}}, good);
  CHECK(service.state(good) == "done");
}

TEST_CASE("only the lease being traced is blamed for a crash, and none for a `bye`") {
  CoordinatorOptions options = service_options();
  options.max_failures = 1;
  SUBCASE("goodbye") {
    Service service(options);
    Hand ann(service, "ann");
    const JobId job = service.submit(small_scene(), many_leases());
    service.turn();
    ann.listen();
    ann.beat();
    ann.say(msg::Bye{"stopped"});
    service.turn(seconds(6));
    CHECK(service.state(job) == "running");
  }
  SUBCASE("a worker without a lease at hand") {
    Service service(options);
    Hand ann(service, "ann");
    const JobId job = service.submit(small_scene(), many_leases());
    service.turn();
    ann.say(msg::Heartbeat{});  // the grant has not arrived yet
    service.turn(seconds(6));
    CHECK(service.job(job).at("waits_for") == "a worker (none is connected)");
    CHECK(service.state(job) == "running");
  }
  SUBCASE("two leases") {
    Service service(options);
    const JobId bad = service.submit(small_scene(), many_leases(), 90);
    RenderSettings one_lease = many_leases();
    one_lease.schedule = SchedulePolicy::static_split;
    const JobId first = service.submit(small_scene(), one_lease, 95);
    Hand ann(service, "ann", 2);
    service.turn();
    service.turn();
    ann.listen();
    REQUIRE(ann.held.size() == 2);
    msg::Heartbeat heartbeat{1, false, {}};
    for (const auto& [lease, grant] : ann.held) {
      heartbeat.epochs.insert(
          lease.first == bad ? heartbeat.epochs.begin() : heartbeat.epochs.end(), lease);
    }
    ann.say(heartbeat);
    service.turn(seconds(6));
    CHECK(service.state(bad) == "failed");
    CHECK(service.state(first) == "running");
  }
}

TEST_CASE(
    "workers lost together by a network failure do not fail a job, and work when they are back") {
  Service service;
  std::vector<std::unique_ptr<Hand>> hands;
  for (const char* name : {"ann", "bob", "cid", "dan", "eve"}) {
    hands.push_back(std::make_unique<Hand>(service, name));
  }
  const JobId job = service.submit(small_scene(), many_leases());
  const auto all_silent = [&] {
    service.turn();
    service.turn();
    for (const auto& hand : hands) {
      hand->listen();
      hand->beat();
      REQUIRE_FALSE(hand->held.empty());
    }
    service.turn(seconds(6));  // no worker sends anything
    REQUIRE(service.worker("ann").is_null());
  };
  for (int times = 0; times < 4; ++times) {
    all_silent();
    CHECK(service.state(job) == "running");
    for (const auto& hand : hands) {  // the same processes: they never died
      hand->come_back();
    }
  }
  work(service, {{hands[0].get(), honest}, {hands[1].get(), honest}}, job);
  CHECK(service.sha256(job) == reference_sha256(small_scene(), many_leases()));
}

TEST_CASE("a process that was believed dead gets leases when it returns") {
  Service service;
  Hand ann(service, "ann");
  Hand one(service, "one", "10.0.0.7");
  Hand two(service, "two", "10.0.0.7");
  const JobId job = service.submit(small_scene(), many_leases());
  work(service, {{&ann, honest}, {&one, idle}, {&two, idle}}, job, 1);
  work(service, {{&ann, idle}}, job, 12, milliseconds(500));  // the others are silent
  REQUIRE(service.worker("one").is_null());
  REQUIRE(service.state(job) == "running");
  Hand three(service, "three", "10.0.0.7");
  REQUIRE(service.worker("three").at("state") == "backoff");
  one.come_back();
  two.come_back();
  for (const char* name : {"one", "two", "three"}) {
    CHECK(service.worker(name).at("state") == "ready");
  }
}

TEST_CASE("a failed job remains failed after a restart, and keeps its rows for a requeue") {
  CrashStore store(0, 1);
  Service service(service_options(), &store);
  Hand ann(service, "ann");
  const JobId job = service.submit(small_scene(), many_leases());
  work(service, {{&ann, honest}}, job, 2);
  work(service, {{&ann, failing}}, job, 1000);
  service.restart();
  CHECK(service.state(job) == "failed");
  CHECK(contains(service.job(job).at("reason"), "not enough memory"));
  CHECK_FALSE(store.committed_rows(job).empty());
}

TEST_CASE("a paused job gets no leases, accepts results, and continues when it is resumed") {
  CrashStore store(0, 1);
  Service service(service_options(), &store);
  Hand ann(service, "ann");
  const JobId job = service.submit(small_scene(), many_leases(), 90);
  const JobId other = service.submit(small_scene(), many_leases());
  service.turn();
  ann.listen();
  CHECK(service.ask<msg::Job>(msg::SteerJob{1, job, msg::JobAction::pause}).job.at("state") ==
        "paused");
  CHECK(contains(service.job(job).at("reason"), "parray resume"));
  ann.send_honest(ann.put_down());
  service.turn();
  ann.listen();
  CHECK(ann.verdicts == std::vector<msg::Verdict>{msg::Verdict::accepted});
  CHECK(service.state(job) == "paused");
  CHECK(service.job(job).at("progress") > 0);
  work(service, {{&ann, honest}}, other);
  CHECK(service.state(other) == "done");
  service.restart();  // it is still paused after a restart
  ann.join();
  CHECK(service.state(job) == "paused");
  service.turn(seconds(1));
  ann.listen();
  CHECK(ann.held.empty());
  CHECK(service.ask<msg::Job>(msg::SteerJob{1, job, msg::JobAction::resume}).job.at("state") ==
        "queued");
  work(service, {{&ann, honest}}, job);
  CHECK(service.sha256(job) == reference_sha256(small_scene(), many_leases()));
  const auto refusal = service.ask<msg::Error>(msg::SteerJob{1, job, msg::JobAction::pause});
  CHECK(contains(refusal.message, "is done"));
}

TEST_CASE("a job that is paused before its start does not block others") {
  CoordinatorOptions options = service_options();
  options.memory = JobPicture::memory(many_leases()) + (1 << 20);  // of one job
  Service service(options);
  const JobId first = service.submit(small_scene(), many_leases(), 90);
  const JobId second = service.submit(small_scene(), many_leases());
  service.ask<msg::Job>(msg::SteerJob{1, first, msg::JobAction::pause});
  Hand ann(service, "ann");
  work(service, {{&ann, honest}}, second);
  CHECK(service.state(second) == "done");
  CHECK(service.state(first) == "paused");
  CHECK(service.ask<msg::Job>(msg::SteerJob{1, first, msg::JobAction::cancel}).job.at("state") ==
        "cancelled");
}

}  // namespace parray::test
