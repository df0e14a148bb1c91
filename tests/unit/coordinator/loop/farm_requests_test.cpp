#include <doctest/doctest.h>

#include <nlohmann/json.hpp>

#include "tests/support/farm_rig.h"
#include "tests/support/rooms.h"

namespace parray {
namespace {

using nlohmann::json;
using test::FarmRig;

json farm_map(FarmRig& rig, bool history = false) {
  msg::ShowFarm m{1, history};
  rig.farm.outbox.clear();
  rig.clients.on(rig.farm.now, "client", m);
  return rig.sent<msg::Farm>().at(0).farm;
}

json worker_map(FarmRig& rig, const std::string& name) {
  msg::ShowWorker m{1, name};
  rig.farm.outbox.clear();
  rig.clients.on(rig.farm.now, "client", m);
  return rig.sent<msg::Worker>().at(0).worker;
}

std::vector<std::string> kinds_of(const json& farm) {
  std::vector<std::string> kinds;
  for (const json& event : farm.at("events")) kinds.push_back(event.at("kind"));
  return kinds;
}

TEST_CASE("users are listed with share, jobs and thread-seconds, the largest first") {
  FarmRig rig;
  rig.add_job(1, "ann").record.state = JobState::done;
  rig.add_job(2, "ann").record.share = 3;  // the latest counts
  rig.add_job(3, "bob").record.state = JobState::failed;
  rig.farm.watch.account("bob").thread_seconds = 7;
  rig.farm.watch.account("carol").thread_seconds = 9;
  const json users = farm_map(rig).at("users");
  REQUIRE(users.size() == 3);
  CHECK(users[0].at("user") == "carol");  // has no job any more
  CHECK(users[0].at("open_jobs") == 0);
  CHECK(users[1].at("user") == "bob");
  CHECK(users[1].at("failed_jobs") == 1);
  CHECK(users[2].at("user") == "ann");
  CHECK(users[2].at("share") == 3);
  CHECK(users[2].at("open_jobs") == 1);
  CHECK(users[2].at("done_jobs") == 1);
  CHECK(users[2].at("queue_seconds_mean").is_null());
}

TEST_CASE("the time left is unknown without workers, and 0 without jobs") {
  FarmRig rig;
  CHECK(farm_map(rig).at("seconds_left") == 0);
  rig.add_job(1);
  CHECK(farm_map(rig).at("seconds_left").is_null());
  rig.join("peer", "one");
  const json farm = farm_map(rig);
  CHECK(farm.at("seconds_left").get<double>() ==
        doctest::Approx(farm.at("thread_seconds_left").get<double>() / 2));
}

TEST_CASE("the wait of a job until its first lease counts once for its user") {
  FarmRig rig;
  Job& job = rig.add_job(1, "ann");
  job.queued_at = rig.farm.since_1970(rig.farm.now);
  rig.farm.now += seconds(30);
  CHECK(farm_map(rig).at("oldest_queued_seconds") == doctest::Approx(30));
  rig.farm.note_begun(job);
  rig.farm.note_begun(job);
  job.record.state = JobState::running;
  const json farm = farm_map(rig);
  CHECK(farm.at("users")[0].at("queue_seconds_mean") == doctest::Approx(30));
  CHECK(farm.at("since_start").at("jobs_begun") == 1);
  CHECK(farm.at("oldest_queued_seconds") == 0);
}

TEST_CASE("a worker that disappears is lost, one that says goodbye has left") {
  FarmRig rig;
  rig.join("a", "one");
  rig.join("b", "two");
  rig.workers.lose_worker(rig.farm.now, "a", "silent for too long", true);
  msg::Bye bye{"worker stopped"};
  rig.workers.on(rig.farm.now, "b", bye);
  json farm = farm_map(rig);
  CHECK(kinds_of(farm) == std::vector<std::string>{"left", "lost", "joined", "joined"});
  CHECK(farm.at("since_start").at("workers_lost") == 1);
  REQUIRE(farm.at("left").size() == 2);
  CHECK(farm.at("left")[1].at("name") == "one");
  CHECK(farm.at("left")[1].at("reason") == "silent for too long");
  CHECK(farm.at("left")[1].at("host") == "host of one");
  rig.join("c", "one");
  CHECK(farm_map(rig).at("left").size() == 1);
}

TEST_CASE("a message about a worker that left does not mention it after an hour") {
  FarmRig rig;
  rig.join("a", "one");
  rig.workers.lose_worker(rig.farm.now, "a", "silent for too long", true);
  rig.farm.now += seconds(3600);
  CHECK(rig.farm.why_no_worker("one") ==
        "no worker 'one' is connected: it was lost 3600 s ago (silent for too long)");
  rig.farm.now += seconds(1);
  CHECK(rig.farm.why_no_worker("one") ==
        "no worker 'one' is connected: parray workers lists those that are");
}

TEST_CASE("drains, readmissions and ends of jobs are events") {
  FarmRig rig;
  rig.join("a", "one");
  rig.farm.sender = {Role::admin, "carol"};
  msg::SteerWorkers drain{1, msg::WorkerAction::drain, false, "one"};
  rig.clients.on(rig.farm.now, "client", drain);
  drain.action = msg::WorkerAction::readmit;
  rig.clients.on(rig.farm.now, "client", drain);
  rig.add_job(7, "ann");
  msg::SteerJob cancel{1, 7, msg::JobAction::cancel, 50};
  rig.clients.on(rig.farm.now, "client", cancel);
  const json farm = farm_map(rig);
  CHECK(kinds_of(farm) ==
        std::vector<std::string>{"job_cancelled", "readmitted", "drained", "joined"});
  CHECK(farm.at("events")[0].at("job") == 7);
  CHECK(farm.at("events")[1].at("worker") == "one");
  CHECK(farm.at("since_start").at("jobs_ended").at("cancelled") == 1);
}

TEST_CASE("the history has one entry for ten seconds, the present state last") {
  FarmRig rig;
  rig.farm.note_history();
  rig.join("peer", "one").held = 1;
  rig.add_job(1);
  rig.farm.watch.samples.add(seconds(15), 500);
  rig.farm.now = seconds(25);
  const json history = farm_map(rig, true);
  CHECK(history.at("interval") == 10);
  CHECK(history.at("end") == doctest::Approx(rig.farm.since_1970(seconds(20))));
  CHECK(history.at("samples_per_second") == json({0.0, 50.0}));
  CHECK(history.at("busy_threads") == json({2, 2}));
  CHECK(history.at("threads") == json({2, 2}));
  CHECK(history.at("queued") == json({1, 1}));
}

TEST_CASE("a worker map states facts of its machine, and null for what an older worker hides") {
  FarmRig rig;
  rig.farm.sender.address = "10.0.0.7";
  msg::Hello hello = FarmRig::hello("one");
  hello.release = "9.9";
  hello.processors = 64;
  hello.memory_bytes = 1 << 20;
  rig.workers.on(rig.farm.now, "a", hello);
  rig.join("b", "old");
  msg::Heartbeat beat;
  beat.load = 2.5;
  rig.workers.on(rig.farm.now, "a", beat);
  const json one = worker_map(rig, "one");
  CHECK(one.at("version") == "9.9");
  CHECK(one.at("processors") == 64);
  CHECK(one.at("memory_bytes") == 1 << 20);
  CHECK(one.at("load") == 2.5);
  CHECK(one.at("address") == "10.0.0.7");
  CHECK(one.at("since") == doctest::Approx(rig.farm.since_1970(rig.farm.now)));
  const json old = worker_map(rig, "old");
  CHECK(old.at("version") == "");
  CHECK(old.at("processors").is_null());
  CHECK(old.at("memory_bytes").is_null());
  CHECK(old.at("load").is_null());
  CHECK(old.at("tracing").is_null());
}

TEST_CASE("a worker map says for how long the worker traces which job, while it holds a lease") {
  FarmRig rig;
  WorkerRecord& worker = rig.join("peer", "one");
  msg::Heartbeat beat;
  beat.epochs = {{7, 1}};
  rig.workers.on(rig.farm.now, "peer", beat);
  rig.farm.now += seconds(5);
  beat.epochs = {{7, 2}};
  rig.workers.on(rig.farm.now, "peer", beat);
  CHECK(worker_map(rig, "one").at("tracing").is_null());  // the heartbeat is older than the lease
  worker.held = 1;
  CHECK(worker_map(rig, "one").at("tracing") == json({{"job", 7}, {"seconds", 5.0}}));
  beat.epochs = {{8, 3}};
  rig.workers.on(rig.farm.now, "peer", beat);
  CHECK(worker_map(rig, "one").at("tracing") == json({{"job", 8}, {"seconds", 0.0}}));
}

TEST_CASE("a drained worker contributes nothing, although its speed is known") {
  FarmRig rig;
  WorkerRecord& worker = rig.join("peer", "one");
  worker.samples.add(seconds(1), 1200);
  rig.farm.workers.measure(worker, 1000, 1);
  rig.farm.now = seconds(21);
  CHECK(worker_map(rig, "one").at("contribution") == doctest::Approx(60));
  rig.farm.now = seconds(200);
  const json later = worker_map(rig, "one");
  CHECK(later.at("contribution") == 0);
  CHECK(later.at("samples_per_second") == 1000);
}

TEST_CASE("a worker's last 20 failures are listed, the newest first, and all are counted") {
  FarmRig rig;
  WorkerRecord& worker = rig.join("peer", "one");
  for (std::uint64_t i = 0; i < 30; ++i) worker.note_failure(seconds(i), i, std::string(3000, 'x'));
  const json map = worker_map(rig, "one");
  CHECK(map.at("failures") == 30);
  REQUIRE(map.at("recent_failures").size() == 20);
  CHECK(map.at("recent_failures")[0].at("job") == 29);
  CHECK(map.at("recent_failures")[0].at("reason").get<std::string>().size() <= 200);
}

TEST_CASE("a worker's history begins when it joins") {
  FarmRig rig;
  rig.farm.now = seconds(100);
  WorkerRecord& worker = rig.join("peer", "one");
  worker.samples.add(seconds(101), 70);
  rig.farm.now = seconds(125);
  const json history = worker_map(rig, "one").at("history");
  CHECK(history.at("samples_per_second") == json({7.0, 0.0}));
  CHECK(history.at("end") == doctest::Approx(rig.farm.since_1970(seconds(120))));
}

TEST_CASE("of workers with one name, the one that joined last is shown") {
  FarmRig rig;
  rig.join("b", "one");
  rig.join("a", "one").hello.release = "new";
  CHECK(worker_map(rig, "one").at("version") == "new");
}

}  // namespace
}  // namespace parray
