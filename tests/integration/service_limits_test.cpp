// The limits of what one client, one worker or one disk can do to a coordinator.
#include <doctest/doctest.h>

#include <algorithm>
#include <deque>

#include "common/scene/settings.h"
#include "tests/support/contains.h"
#include "tests/support/crash_store.h"
#include "tests/support/rooms.h"
#include "tests/support/service.h"
#include "tests/support/stored_state.h"

namespace parray::test {
namespace {

/// A link with many queued messages.
class PiledLink final : public Link {
 public:
  bool send(const PeerId& /*to*/, Envelope /*content*/) override {
    ++sent;
    return true;
  }
  std::optional<Delivery> receive() override {
    if (arrived.empty()) return {};
    Delivery first = std::move(arrived.front());
    arrived.pop_front();
    return first;
  }
  void wait(Time /*timeout*/) override {}
  void wake() noexcept override {}

  std::deque<Delivery> arrived;
  std::size_t sent = 0;
};

}  // namespace

TEST_CASE("a target below the rounding error is refused for every client") {
  Service service(service_options());
  RenderSettings settings = many_leases();
  settings.samples_per_pixel = 1 << 20;
  settings.target_error = 1e-9;
  const auto error = service.ask<msg::Error>(service.submission(small_scene(), settings));
  CHECK(error.status == 2);
  CHECK(contains(error.message, "--target-error 1e-09 is too small: pictures hold 32-bit"));
  CHECK(service.ask<msg::Jobs>(msg::ListJobs{1}).jobs.empty());
  settings.target_error = 1e-3;
  CHECK(service.submit(small_scene(), settings) > 0);
}

TEST_CASE(
    "on a full disk jobs wait with the reason, nothing is lost, and they continue by themselves") {
  CrashStore store(0, 1);
  Service service(service_options(), &store);
  Hand ann(service, "ann");
  Hand bob(service, "bob");
  const JobId job = service.submit(small_scene(), many_leases());
  work(service, {{&ann, honest}, {&bob, honest}}, job, 2);
  ann.listen();
  bob.listen();
  const auto accepted = ann.verdicts.size() + bob.verdicts.size();
  store.fill(true);
  work(service, {{&ann, honest}, {&bob, honest}}, job, 20);
  CHECK(contains(service.job(job).at("waits_for"), "disk full"));
  CHECK(service.state(job) == "running");
  CHECK(ann.held.empty());  // nothing more is granted
  CHECK(ann.verdicts.size() + bob.verdicts.size() == accepted);
  const auto refused = service.ask<msg::Error>(service.submission(small_scene(), many_leases()));
  CHECK(refused.status == 1);
  CHECK(contains(refused.message, "disk full"));
  store.fill(false);
  work(service, {{&ann, honest}, {&bob, honest}}, job);
  CHECK(ann.verdicts.size() + bob.verdicts.size() > accepted);
  CHECK(service.sha256(job) == reference_sha256(small_scene(), many_leases()));
}

TEST_CASE("a picture that finds no room on the disk is finished when there is some") {
  CrashStore store(0, 1);
  Service service(service_options(), &store);
  Hand ann(service, "ann");
  RenderSettings one_lease = many_leases();
  one_lease.schedule = SchedulePolicy::static_split;
  const JobId job = service.submit(small_scene(), one_lease);
  service.turn();
  ann.listen();
  store.fill(true);
  ann.send_honest(ann.put_down());
  for (int i = 0; i < 5; ++i) {
    service.turn(seconds(1));
    ann.beat();
    CHECK(service.state(job) == "finishing");
  }
  CHECK(contains(service.job(job).at("reason").get<std::string>() +
                     service.job(job).at("waits_for").get<std::string>(),
                 "full"));
  store.fill(false);
  service.turn(seconds(2));
  service.turn();
  CHECK(service.state(job) == "done");
  CHECK(service.sha256(job) == reference_sha256(small_scene(), one_lease));
}

TEST_CASE("a coordinator that was stopped for 30 s loses no worker whose messages are queued") {
  Service service;
  PiledLink link;
  constexpr int workers = 1000;
  for (int i = 0; i < workers; ++i) {
    const std::string name = "w" + std::to_string(i);
    service.say(name, msg::Hello{protocol_version, name, name, 1, 1, trace_version, "same"});
  }
  service.turn();
  for (int beat = 0; beat < 3; ++beat) {
    for (int i = 0; i < workers; ++i) {
      link.arrived.push_back({"w" + std::to_string(i), Message(msg::Heartbeat{})});
    }
  }
  int turns = 0;
  for (const Time now = service.now() + seconds(30); !link.arrived.empty(); ++turns) {
    take_turn(service.coordinator(), link, now);
  }
  CHECK(turns > 5);
  service.turn(seconds(30));
  CHECK(link.sent == 3 * workers);  // a heartbeat_ack each: no worker was asked to identify itself
  service.turn(seconds(6));
  CHECK(service.ask<msg::Workers>(msg::ListWorkers{1}).total == 0);  // now they are silent
}

TEST_CASE("the more workers there are, the less often each sends, and the later it is lost") {
  CoordinatorOptions options = service_options();
  options.heartbeat_workers = 2;
  options.lease_timeout = 10 * options.heartbeat;
  Service service(options);
  const auto ms = [](Time t) {
    return static_cast<std::uint32_t>(std::chrono::duration_cast<milliseconds>(t).count());
  };
  const auto told = [&](const std::string& name) {
    service.turn(Time(0));
    const auto welcomes = service.heard<msg::Welcome>(name);
    return welcomes.empty() ? 0 : welcomes.back().heartbeat_ms / ms(options.heartbeat);
  };
  const auto join = [&](const std::string& name) {
    service.say(name, msg::Hello{protocol_version, name, name, 1, 1, trace_version, "same"});
    return told(name);
  };
  const auto beat = [&](const std::string& name) {
    service.say(name, msg::Heartbeat{});
    return told(name);
  };
  const auto there = [&] { return service.ask<msg::Workers>(msg::ListWorkers{1}).total; };
  CHECK(join("a") == 1);
  CHECK(join("b") == 1);
  CHECK(beat("a") == 0);  // nothing new
  CHECK(join("c") == 2);
  CHECK(beat("a") == 2);
  CHECK(beat("a") == 0);
  for (const char* name : {"d", "e", "f", "g", "h", "i"}) join(name);
  CHECK(beat("a") == 3);  // no more: its leases are to be heard of three times
  const Time silence = options.silence;
  service.turn(silence);  // b was told no more than the shortest
  CHECK(there() == 8);
  service.turn(silence);  // c and d
  CHECK(there() == 6);
  CHECK(beat("e") == 0);
  service.turn(silence - milliseconds(1));
  CHECK(there() == 6);
  service.turn(milliseconds(200));
  CHECK(there() == 1);
  CHECK(beat("e") == 1);  // it may not have heard that
  service.turn(3 * silence - milliseconds(1));
  CHECK(there() == 1);
  service.turn(milliseconds(200));
  CHECK(there() == 0);
}

TEST_CASE("a lease is not taken back while its worker's heartbeat is queued") {
  Service service;
  Hand ann(service, "ann");
  const JobId job = service.submit(small_scene(), many_leases());
  service.turn();
  ann.listen();
  service.turn(seconds(30), false);
  ann.beat();
  service.turn(milliseconds(1));
  ann.listen();
  CHECK(ann.held.size() == 1);
  ann.send_honest(ann.put_down());
  service.turn();
  ann.listen();
  CHECK(ann.verdicts == std::vector<msg::Verdict>{msg::Verdict::accepted});
  CHECK(service.job(job).at("progress") > 0);
}

TEST_CASE("no time that a worker states makes it infinitely fast or leaves others without leases") {
  Service service;
  Hand odd(service, "odd");
  Hand ann(service, "ann");
  RenderSettings settings = many_leases();
  settings.schedule = SchedulePolicy::weighted;
  settings.height = 4000;
  settings.samples_per_pixel = 1;
  service.submit(small_scene(), settings);
  service.turn();
  odd.listen();
  REQUIRE_FALSE(odd.held.empty());
  const msg::Grant grant = odd.put_down();
  msg::Result result = Hand::result(grant, Hand::trace(small_scene(), grant));
  for (const double seconds : {-1.0, -5e-324, 1e300}) {  // not heard at all
    result.seconds = seconds;
    service.say(odd.peer(), result);
  }
  CHECK(service.tally().malformed == 3);
  result.seconds = 5e-324;
  service.say(odd.peer(), result);
  service.turn();
  CHECK(service.tally().accepted == 1);
  const double speed = service.worker("odd").at("samples_per_second");
  CHECK(speed <= 1.001e6 * static_cast<double>(grant.cells.sample_count()));
  ann.listen();
  if (!ann.held.empty()) ann.send_honest(ann.put_down());
  service.turn();
  ann.listen();
  REQUIRE_FALSE(ann.held.empty());
  CHECK(ann.held.begin()->second.cells.range.count() > 0);
}

TEST_CASE("a list of workers says how many there are in all") {
  Service service;
  for (int i = 0; i < 1500; ++i) {
    const std::string name = "w" + std::to_string(i);
    service.say(name, msg::Hello{protocol_version, name, name, 1, 1, trace_version, "same"});
  }
  service.turn();
  const auto answer = service.ask<msg::Workers>(msg::ListWorkers{1});
  CHECK(answer.workers.size() == 1000);
  CHECK(answer.total == 1500);
}

TEST_CASE("a worker beyond the limit is refused with the option's name") {
  CoordinatorOptions options = service_options();
  options.max_workers = 2;
  Service service(options);
  for (const char* name : {"a", "b", "c"}) {
    service.say(name, msg::Hello{protocol_version, name, name, 1, 1, trace_version, "same"});
  }
  service.turn();
  const auto refusals = service.heard<msg::Refuse>("c");
  REQUIRE(refusals.size() == 1);
  CHECK(contains(refusals[0].reason, "--max-workers"));
  CHECK(service.heard<msg::Refuse>("b").empty());
}

TEST_CASE("30 000 hellos of new processes, or malformed messages, write only a short log") {
  Service service;
  for (int i = 0; i < 30'000; ++i) {
    service.say("w",
                msg::Hello{protocol_version, "w", std::to_string(i), 1, 1, trace_version, "same"});
    service.say("x", msg::Hello{protocol_version, "x", "x", 1, 1, trace_version, "another"});
    service.say_frames("y", {std::string("no message")});
  }
  service.turn();
  const std::string log = service.log();
  CHECK(std::count(log.begin(), log.end(), '\n') < 200);
  service.turn(seconds(20));
  service.say_frames("y", {std::string("no message")});
  CHECK(contains(service.log(), "more lines like these"));
}

TEST_CASE("a job says what it waits for") {
  Service service;
  const JobId job = service.submit(small_scene(), many_leases());
  CHECK(service.job(job).at("waits_for") == "a worker (none is connected)");
  Hand ann(service, "ann");
  service.turn();
  CHECK(service.job(job).at("waits_for") == "");
  CHECK(service.state(job) == "running");
}

TEST_CASE("an invalid scene makes no job; one that was damaged by the network counts as lost") {
  CrashStore store(0, 1);
  for (Store* kept : {static_cast<Store*>(nullptr), static_cast<Store*>(&store)}) {
    Service service(service_options(), kept);
    msg::Submit bad = service.submission(small_scene(), many_leases());
    bad.scene = ScenePayload(Bulk::of("no scene"));
    CHECK(service.ask<msg::Error>(bad).status == 2);
    const Frames whole = encode(service.submission(small_scene(), many_leases()));
    Frames frames = whole;
    std::string bulk(frames[1].view());
    bulk[bulk.size() / 2] = static_cast<char>(bulk[bulk.size() / 2] ^ 1);
    frames[1] = std::move(bulk);
    service.say_frames("client", frames);
    service.turn();
    CHECK(service.heard<msg::Error>("client").empty());
    CHECK(service.ask<msg::Jobs>(msg::ListJobs{1}).jobs.empty());
    service.say_frames("client", whole);  // the client repeats it
    service.turn();
    CHECK(service.heard<msg::Submitted>("client").size() == 1);
  }
}

TEST_CASE("a job with damaged rows keeps the rows before the damage, and traces the rest again") {
  CrashStore store(0, 1);
  Service service(service_options(), &store);
  Hand ann(service, "ann");
  const JobId job = service.submit(small_scene(), many_leases());
  work(service, {{&ann, honest}}, job, 3);
  const std::uint64_t accepted = service.tally().accepted;
  const std::size_t sound = rows_of(store, job).size();
  REQUIRE(accepted > 0);
  store.append_rows(job, "rubbish");
  store.append_rows(job, "what stood behind it");
  service.restart();
  ann.join();
  service.turn();
  CHECK(rows_of(store, job).size() >= sound);
  work(service, {{&ann, honest}}, job);
  CHECK(service.state(job) == "done");
  CHECK(contains(service.log(), "workers will trace the rest again"));
  CHECK(contains(service.job(job).at("events").dump(), "stored results are damaged"));
  CHECK(service.sha256(job) == reference_sha256(small_scene(), many_leases()));
}

TEST_CASE(
    "a clock that jumps forgets no job, and time in which no coordinator ran does not count") {
  double clock = 1e9;
  CoordinatorOptions options = service_options();
  options.wall_clock = [&clock] { return clock; };
  options.limits.keep_seconds = 1000;
  CrashStore store(0, 1);
  Service service(options, &store);
  Hand ann(service, "ann");
  const JobId job = service.submit(small_scene(), many_leases());
  work(service, {{&ann, honest}}, job);
  clock += 100 * 86400;
  service.turn(seconds(500));
  CHECK(service.state(job) == "done");
  service.turn(seconds(60));
  service.restart();
  clock += 100 * 86400;
  service.turn(seconds(10));
  CHECK(service.state(job) == "done");
  service.turn(seconds(400));
  CHECK(service.state(job) == "done");
  service.turn(seconds(60));
  service.turn(seconds(200));
  CHECK(contains(service.refusal(msg::ShowJob{1, job}), "no job"));
}

TEST_CASE("a restart keeps the progress of a job that waits for its turn") {
  CrashStore store(0, 1);
  Service service(service_options(), &store);
  Hand ann(service, "ann");
  const JobId job = service.submit(small_scene(), many_leases());
  work(service, {{&ann, honest}}, job, 3);
  service.turn(seconds(4));
  service.turn(seconds(2));
  const double progress = service.job(job).at("progress");
  REQUIRE(progress > 0);
  service.restart();
  service.say("client", msg::ShowJob{1, job});
  CHECK(service.job(job).at("progress").get<double>() == doctest::Approx(progress).epsilon(0.01));
}

TEST_CASE("a coordinator that stops stores the progress of its jobs first") {
  CrashStore store(0, 1);
  Service service(service_options(), &store);
  Hand ann(service, "ann");
  const JobId job = service.submit(small_scene(), many_leases());
  work(service, {{&ann, honest}}, job, 3);
  const nlohmann::json before = service.job(job);
  REQUIRE(before.at("progress") > 0);
  service.coordinator().keep_progress();
  service.restart();
  service.say("client", msg::ShowJob{1, job});
  const nlohmann::json after = service.job(job);
  CHECK(after.at("progress").get<double>() ==
        doctest::Approx(before.at("progress").get<double>()).epsilon(0.01));
  CHECK(after.at("samples_taken") == before.at("samples_taken"));
}

TEST_CASE("a coordinator that cannot commit for too long sends its workers away") {
  CoordinatorOptions options = service_options();
  options.release_after = seconds(15);
  options.silence = seconds(60);
  CrashStore store(0, 1);
  Service service(options, &store);
  Hand ann(service, "ann");
  service.submit(small_scene(), many_leases());
  service.turn();
  store.fill(true);
  service.turn();
  service.turn(seconds(14));
  CHECK(service.heard<msg::Bye>(ann.peer()).empty());
  service.turn(seconds(2));
  CHECK(service.heard<msg::Bye>(ann.peer()).size() == 1);
  const auto silent = [&] {
    service.turn();
    return service.heard<msg::Welcome>(ann.peer()).empty() &&
           service.heard<msg::Identify>(ann.peer()).empty();
  };
  service.heard<msg::Welcome>(ann.peer());
  ann.come_back();
  ann.beat();
  CHECK(silent());
  store.fill(false);
  service.turn();
  ann.come_back();
  CHECK_FALSE(silent());
}

}  // namespace parray::test
