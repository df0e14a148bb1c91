// Users share a farm: turns, limits, and their rights on jobs and workers.
#include <doctest/doctest.h>

#include <cmath>
#include <map>
#include <string>
#include <vector>

#include "common/scene/settings.h"
#include "tests/support/contains.h"
#include "tests/support/crash_store.h"
#include "tests/support/rooms.h"
#include "tests/support/service.h"

namespace parray::test {
namespace {

/// Settings of a picture with very many short leases.
RenderSettings long_job() {
  RenderSettings settings = many_leases();
  settings.height = 4000;
  settings.samples_per_pixel = 64;
  settings.schedule = SchedulePolicy::weighted;
  return settings;
}
CoordinatorOptions short_leases() {
  CoordinatorOptions options = service_options();
  options.lease_length = {0.001, 0.004};
  return options;
}

/// So many leases, each of which takes as long as its samples say; what each job had of them.
std::map<JobId, double> watch(Service& service, Hand& hand, int leases) {
  std::map<JobId, double> seconds;
  for (int i = 0; i < leases; ++i) {
    service.turn();
    hand.listen();
    hand.beat();
    REQUIRE_FALSE(hand.held.empty());
    const msg::Grant grant = hand.put_down();
    msg::Result result = Hand::result(grant, Hand::trace(small_scene(), grant));
    result.seconds = static_cast<double>(grant.cells.range.count()) * 1e-3;
    seconds[grant.job] += result.seconds;
    hand.say(result);
  }
  return seconds;
}

}  // namespace

TEST_CASE(
    "two users get half of the farm each, independent of the order and number of their jobs") {
  Service service(short_leases());
  Hand hand(service, "w");
  const JobId of_ann = service.submit(small_scene(), long_job(), 50, "ann");
  watch(service, hand, 20);
  const JobId of_bob = service.submit(small_scene(), long_job(), 50, "bob");
  service.submit(small_scene(), long_job(), 90, "ann");
  watch(service, hand, 20);
  std::map<std::string, double> had;
  for (const auto& [job, seconds] : watch(service, hand, 100)) {
    had[service.job(job).at("user")] += seconds;
  }
  CHECK(had["ann"] / had["bob"] == doctest::Approx(1).epsilon(0.05));
  CHECK(service.job(of_ann).at("user") == "ann");
  CHECK(service.job(of_bob).at("user") == "bob");
}

TEST_CASE("a short job beside a long one of the same user begins with the next lease") {
  Service service(short_leases());
  Hand hand(service, "w");
  service.submit(small_scene(), long_job());
  watch(service, hand, 20);
  const JobId quick = service.submit(small_scene(), many_leases());
  service.turn();  // the coordinator allocates its picture
  watch(service, hand, 1);
  hand.listen();
  CHECK(watch(service, hand, 2).contains(quick));
  for (int i = 0; i < 500 && service.state(quick) != "done"; ++i) watch(service, hand, 1);
  CHECK(service.sha256(quick) == reference_sha256(small_scene(), many_leases()));
}

TEST_CASE("a job's priority can be changed while it is rendered") {
  Service service(short_leases());
  Hand hand(service, "w");
  const JobId first = service.submit(small_scene(), long_job());
  const JobId second = service.submit(small_scene(), long_job());
  watch(service, hand, 20);
  CHECK(service.steer(second, msg::JobAction::prioritise, 51).at("priority") == 51);
  service.turn();
  watch(service, hand, 3);
  CHECK(watch(service, hand, 20).size() == 1);
  CHECK(watch(service, hand, 20).contains(second));
  CHECK(service.steer(first, msg::JobAction::prioritise, 52).at("priority") == 52);
  watch(service, hand, 3);
  CHECK(watch(service, hand, 20).contains(first));
}

namespace {

/// Lets so many seconds pass, in which the worker traces leases of a second each, but those of
/// `dear` take 20 seconds. Returns how many seconds each job had.
std::map<JobId, int> pass_time(Service& service, Hand& hand, int duration, JobId dear = 0) {
  std::map<JobId, int> had;
  for (int passed = 0; passed < duration;) {
    hand.listen();
    hand.beat();
    REQUIRE_FALSE(hand.held.empty());
    const msg::Grant grant = hand.put_down();
    msg::Result result = Hand::result(grant, Hand::trace(small_scene(), grant));
    const int took = grant.job == dear ? 20 : 1;
    result.seconds = took;
    passed += took;
    had[grant.job] += took;
    hand.say(result);
    service.turn(seconds(took));
  }
  return had;
}

}  // namespace

TEST_CASE("a job without a turn for 10 minutes gets 5 % of its user's turns, and no more") {
  RenderSettings endless = long_job();
  endless.samples_per_pixel = 1;
  endless.height = 12000;
  CoordinatorOptions options = short_leases();
  options.silence = seconds(60);
  options.lease_timeout = seconds(60);
  Service service(options);
  Hand hand(service, "w");
  const JobId first = service.submit(small_scene(), endless, 100, "ann");
  service.turn();
  pass_time(service, hand, 20);
  const JobId last = service.submit(small_scene(), endless, 0, "ann");
  CHECK_FALSE(pass_time(service, hand, 590).contains(last));
  pass_time(service, hand, 30);
  SUBCASE("alone with the first") {
    auto had = pass_time(service, hand, 1000);
    CHECK(had[last] == doctest::Approx(50).epsilon(0.1));
    CHECK(had[first] + had[last] == 1000);
  }
  SUBCASE("whose leases take 20 times as long") {
    pass_time(service, hand, 1000, last);
    CHECK(pass_time(service, hand, 2000, last)[last] == doctest::Approx(100).epsilon(0.25));
  }
  SUBCASE("beside another user, who does not pay for it") {
    const JobId of_bob = service.submit(small_scene(), endless, 50, "bob");
    pass_time(service, hand, 10);
    auto had = pass_time(service, hand, 1000);
    CHECK(had[of_bob] == doctest::Approx(500).epsilon(0.05));
    CHECK(had[last] == doctest::Approx(25).epsilon(0.1));
  }
  SUBCASE("together with another job that starves") {
    const JobId other = service.submit(small_scene(), endless, 50, "ann");
    pass_time(service, hand, 650);
    auto had = pass_time(service, hand, 1000);
    CHECK(had[last] == doctest::Approx(25).epsilon(0.1));
    CHECK(had[other] == doctest::Approx(25).epsilon(0.1));
  }
  SUBCASE("until its turn comes by right") {
    service.steer(last, msg::JobAction::prioritise, 100);
    service.steer(first, msg::JobAction::prioritise, 0);
    pass_time(service, hand, 30);
    CHECK_FALSE(pass_time(service, hand, 500).contains(first));
    CHECK(pass_time(service, hand, 1000)[first] == doctest::Approx(45).epsilon(0.15));
  }
}

TEST_CASE("a requeued job continues from its rows, also after a restart") {
  CrashStore store(0, 1);
  Service service(service_options(), &store);
  Hand hand(service, "w");
  const JobId job = service.submit(small_scene(), many_leases());
  watch(service, hand, 3);
  service.turn();
  CHECK(service.steer(job, msg::JobAction::cancel).at("state") == "cancelled");
  CHECK(contains(service.refusal(msg::SteerJob{1, job, msg::JobAction::prioritise, 1}), "ended"));
  service.turn();
  const std::size_t kept = store.committed_rows(job).size();
  CHECK(kept >= 3);
  service.restart();
  hand.join();
  CHECK(service.steer(job, msg::JobAction::requeue).at("state") == "queued");
  service.turn();
  service.turn();
  CHECK(service.job(job).at("progress") > 0);
  work(service, {{&hand, honest}}, job);
  CHECK(service.sha256(job) == reference_sha256(small_scene(), many_leases()));
  CHECK(contains(service.refusal(msg::SteerJob{1, job, msg::JobAction::requeue, 0}), "is done"));
}

TEST_CASE("without a store, a requeued job starts from its beginning, with other epochs") {
  Service service;
  Hand hand(service, "w");
  const JobId job = service.submit(small_scene(), many_leases());
  watch(service, hand, 3);
  service.turn();
  hand.listen();
  REQUIRE(hand.held.size() == 1);
  const msg::Grant late = hand.held.begin()->second;
  service.steer(job, msg::JobAction::cancel);
  service.steer(job, msg::JobAction::requeue);
  CHECK(service.job(job).at("progress") == 0);
  hand.beat();
  service.turn();
  hand.listen();
  hand.verdicts.clear();
  hand.send_honest(late);
  service.turn();
  hand.listen();
  CHECK(hand.verdicts == std::vector<msg::Verdict>{msg::Verdict::stale});
  work(service, {{&hand, honest}}, job);
  CHECK(service.sha256(job) == reference_sha256(small_scene(), many_leases()));
}

TEST_CASE("`forget` deletes an ended job with its files, and refuses an unfinished one") {
  CrashStore store(0, 1);
  Service service(service_options(), &store);
  Hand hand(service, "w");
  const JobId job = service.submit(small_scene(), many_leases());
  CHECK(contains(service.refusal(msg::SteerJob{1, job, msg::JobAction::forget, 0}),
                 "cancel it first"));
  work(service, {{&hand, honest}}, job);
  CHECK(service.steer(job, msg::JobAction::forget).at("state") == "done");
  service.turn();
  CHECK(contains(service.refusal(msg::ShowJob{1, job}), "no job"));
  CHECK_FALSE(store.has_picture(job));
  CHECK(store.usage().total == 0);
}

TEST_CASE("a job lists its events") {
  CoordinatorOptions options = service_options();
  options.wall_clock = [] { return 1.5e9; };
  CrashStore store(0, 1);
  Service service(options, &store);
  Hand hand(service, "w");
  const JobId job = service.submit(small_scene(), many_leases(), 50, "ann");
  watch(service, hand, 2);
  service.steer(job, msg::JobAction::pause);
  service.steer(job, msg::JobAction::resume);
  work(service, {{&hand, honest}}, job);
  service.turn();
  const auto before = service.job(job).at("events");
  service.restart();
  std::string story;
  const auto after = service.job(job).at("events");
  for (const auto& event : after) {
    CHECK(event.at("at") == 1.5e9);
    story += event.at("what").get<std::string>() + "; ";
  }
  CHECK(story == "submitted by ann; started; paused by a client; resumed by a client; done; ");
  CHECK(after == before);
}

TEST_CASE("of a long history, the beginning and the end are stored") {
  JobRecord record;
  for (int i = 0; i < 1000; ++i) record.note(i, std::to_string(i));
  CHECK(record.events.size() == 64);
  CHECK(record.events.front().what == "0");
  CHECK(record.events.back().what == "999");
}

TEST_CASE("unfinished jobs and pixels of each user, and pixels of a picture, are limited") {
  CoordinatorOptions options = service_options();
  options.limits.user_jobs = 2;
  const std::size_t pixels = std::size_t{many_leases().width} * many_leases().height;
  options.limits.pixels = 2 * pixels;
  options.limits.user_pixels = 3 * pixels;
  options.limits.user_disk = 1;  // has no effect without a store
  options.limits.disk = 1;
  Service service(options);
  const auto refused = [&](const RenderSettings& settings, const std::string& user) {
    msg::Submit submit = service.submission(small_scene(), settings);
    submit.user = user;
    return service.refusal(submit);
  };
  RenderSettings large = many_leases();
  large.height *= 3;
  CHECK(contains(refused(large, "ann"), "--max-pixels"));
  large.height = 2 * many_leases().height;
  CHECK(refused(large, "ann").empty());
  CHECK(contains(refused(large, "ann"), "--max-user-pixels"));
  CHECK(refused(many_leases(), "ann").empty());
  CHECK(contains(refused(many_leases(), "ann"), "--max-user-jobs"));
  CHECK(refused(many_leases(), "bob").empty());
}

TEST_CASE("submits of one user that arrive at once do not exceed the user's limits") {
  for (const bool pixels : {false, true}) {
    CAPTURE(pixels);
    CoordinatorOptions options = service_options();
    const RenderSettings settings = small_settings(small_scene());
    options.limits.user_jobs = pixels ? 100 : 3;
    options.limits.user_pixels = (pixels ? 3 : 100) * pixel_count(settings);
    Service service(options);
    for (int i = 0; i < 10; ++i) {
      msg::Submit submit = service.submission(small_scene(), settings);
      submit.user = i < 7 ? "ann" : "bob";
      service.say("client", submit);
    }
    service.turn(Time(0));
    CHECK(service.heard<msg::Submitted>("client").size() == 6);
    CHECK(service.heard<msg::Error>("client").size() == 4);
  }
}

TEST_CASE("users share the disk, and ended jobs make room on it, the oldest first") {
  CoordinatorOptions options = service_options();
  CrashStore store(0, 1);
  std::uint64_t one = 0;
  {
    Service service(options, &store);
    Hand hand(service, "w");
    const JobId job = service.submit(small_scene(), many_leases(), 50, "ann");
    work(service, {{&hand, honest}}, job);
    one = store.usage().total;
  }
  options.limits.user_disk = one / 2;
  Service frugal(options, &store);
  frugal.turn();
  frugal.turn(seconds(6));
  msg::Submit submit = frugal.submission(small_scene(), many_leases());
  submit.user = "ann";
  submit.token = "another";
  CHECK(contains(frugal.refusal(submit), "--max-user-disk"));
  options.limits.user_disk = 10 * one;
  options.limits.disk = one + one / 2;
  Service service(options, &store);
  Hand hand(service, "w");
  submit.user = "bob";
  const JobId second = service.ask<msg::Submitted>(submit).job;
  work(service, {{&hand, honest}}, second);
  service.turn();
  service.turn(seconds(6));
  service.turn(seconds(6));
  CHECK(contains(service.refusal(msg::ShowJob{1, 1}), "no job 1"));
  CHECK(service.state(second) == "done");
}

TEST_CASE("a job is stored for a limited time after its end") {
  CoordinatorOptions options = service_options();
  options.limits.keep_seconds = 1000;
  Service service(options);
  Hand hand(service, "w");
  const JobId job = service.submit(small_scene(), many_leases());
  work(service, {{&hand, honest}}, job);
  service.turn(seconds(990));
  CHECK(service.state(job) == "done");
  service.turn(seconds(20));
  CHECK(contains(service.refusal(msg::ShowJob{1, job}), "no job"));
}

TEST_CASE("messages of a peer that sends too often are not read for the rest of a second") {
  CoordinatorOptions options = service_options();
  options.limits.requests = 10;
  Service service(options);
  for (int i = 0; i < 30; ++i) {
    service.say("greedy", msg::ListJobs{1});
    service.say("modest " + std::to_string(i), msg::ListJobs{1});
  }
  service.turn(Time(0));
  CHECK(service.heard<msg::Jobs>("greedy").size() == 10);
  CHECK(service.heard<msg::Jobs>("modest 29").size() == 1);
  service.turn(seconds(1));
  service.say("greedy", msg::ListJobs{1});
  service.turn(Time(0));
  CHECK(service.heard<msg::Jobs>("greedy").size() == 1);
}

TEST_CASE("a drained worker completes its leases and gets no more, also after a restart") {
  CrashStore store(0, 1);
  Service service(service_options(), &store);
  Hand ann(service, "ann", 1, "attic");
  Hand bob(service, "bob", 1, "attic");
  Hand eve(service, "eve", 1, "cellar");
  const JobId job = service.submit(small_scene(), many_leases());
  service.turn();
  service.turn();
  ann.listen();
  REQUIRE(ann.held.size() == 1);
  const auto drain = [&](const std::string& name, bool host) {
    return service.ask<msg::Workers>(msg::SteerWorkers{1, msg::WorkerAction::drain, host, name});
  };
  CHECK(drain("ann", false).workers.at(0).at("state") == "draining");
  ann.send_honest(ann.put_down());
  service.turn();
  ann.listen();
  CHECK(ann.verdicts.back() == msg::Verdict::accepted);
  CHECK(ann.held.empty());
  CHECK(service.worker("ann").at("state") == "drained");
  CHECK(service.worker("bob").at("state") == "ready");
  CHECK(drain("attic", true).workers.size() == 2);
  CHECK(drain("eve", false).workers.size() == 1);
  CHECK(
      service.job(job).at("waits_for") ==
      "a worker (all are drained: readmit one with parray workers readmit NAME, or a drained host "
      "with parray workers readmit HOST --host)");
  service.ask<msg::Workers>(msg::SteerWorkers{1, msg::WorkerAction::readmit, false, "eve"});
  CHECK(service.job(job).at("waits_for") == "");
  service.restart();
  ann.join();
  bob.join();
  eve.join();
  work(service, {{&ann, idle}, {&bob, idle}, {&eve, honest}}, job);
  CHECK(service.state(job) == "done");
  CHECK(ann.held.empty());
  CHECK(bob.held.empty());
  const auto readmit = [&](const std::string& name, bool host) {
    return service.ask<msg::Workers>(msg::SteerWorkers{1, msg::WorkerAction::readmit, host, name});
  };
  CHECK(readmit("attic", true).workers.size() == 2);
  CHECK(service.worker("ann").at("state") == "ready");
  CHECK(drain("nobody", false).workers.empty());
}

TEST_CASE("the quarantine of a faulty worker survives a restart, until it is readmitted") {
  CoordinatorOptions options = service_options();
  options.checks.share = 1;
  CrashStore store(0, 1);
  Service service(options, &store);
  Hand ann(service, "ann");
  Hand bob(service, "bob");
  Hand faulty(service, "faulty");
  const JobId job = service.submit(small_scene(), many_leases());
  work(service, {{&ann, honest}, {&bob, honest}, {&faulty, lying}}, job);
  REQUIRE(service.worker("faulty").at("state") == "quarantined");
  service.restart();
  service.say(faulty.peer(),
              msg::Hello{protocol_version, "faulty", "1", 1, 1, trace_version, "same"});
  service.turn();
  CHECK(service.worker("faulty").at("state") == "quarantined");
  CHECK(contains(service.worker("faulty").at("reason"), "differ from the referee's"));
  service.ask<msg::Workers>(msg::SteerWorkers{1, msg::WorkerAction::readmit, false, "faulty"});
  CHECK(service.worker("faulty").at("state") == "ready");
}

TEST_CASE("a worker that becomes slow gets short leases after its next result") {
  CoordinatorOptions options = short_leases();
  options.lease_length.longest = 0.02;
  Service service(options);
  Hand hand(service, "w");
  service.submit(small_scene(), long_job());
  watch(service, hand, 20);
  service.turn();
  hand.listen();
  const msg::Grant before = hand.put_down();
  msg::Result slow = Hand::result(before, Hand::trace(small_scene(), before));
  slow.seconds = static_cast<double>(before.cells.range.count()) * 1e-2;  // a tenth of its speed
  hand.say(slow);
  service.turn();
  hand.listen();
  const msg::Grant after = hand.put_down();
  CHECK(after.cells.range.count() < before.cells.range.count() / 5);
}

}  // namespace parray::test
