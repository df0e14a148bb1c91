// Checks the answers of PROTOCOL.md: a coordinator over real ZeroMQ, and a worker that the test
// plays.
#include <doctest/doctest.h>

#include <algorithm>
#include <initializer_list>

#include "common/scene/settings.h"
#include "tests/support/rooms.h"
#include "tests/support/served.h"
#include "tests/support/service.h"

namespace parray::test {
namespace {

/// Returns options of a coordinator that keeps silent workers and, unless told otherwise, leases.
CoordinatorOptions quick(Time lease_timeout = seconds(60)) {
  CoordinatorOptions options;
  options.heartbeat = milliseconds(50);
  options.silence = seconds(20);
  options.lease_timeout = lease_timeout;
  options.fingerprint = "same";
  return options;
}

class Peer : public Speaker {
 public:
  using Speaker::Speaker;

  void join(const std::string& name) {
    say(msg::Hello{protocol_version, name, name, 1, 1, trace_version, "same"});
    hear<msg::Welcome>();
  }

  JobId submit(const Scene& scene, const RenderSettings& settings) {
    msg::Submit submit;
    submit.token = "token";
    submit.name = "scene";
    submit.settings = settings;
    submit.scene = ScenePayload(std::make_shared<const Scene>(scene));
    say(submit);
    return hear<msg::Submitted>().job;
  }
};

msg::Result traced(const Scene& scene, const msg::Grant& grant) {
  return Hand::result(grant, Hand::trace(scene, grant));
}

struct OneLease {
  OneLease() : settings(small_settings(scene)) { settings.schedule = SchedulePolicy::static_split; }
  Scene scene = small_scene();
  RenderSettings settings;
};

}  // namespace

TEST_CASE("a result after its lease's deadline is stale, and the lease is granted again") {
  const Server server(quick(milliseconds(300)));
  const OneLease job;
  Peer worker(server);
  worker.join("slow");
  Peer client(server);
  client.submit(job.scene, job.settings);
  const auto first = worker.hear<msg::Grant>();
  const auto second = worker.hear<msg::Grant>();  // no heartbeat named the first: it expired
  CHECK(second.cells.range == first.cells.range);
  CHECK(second.epoch != first.epoch);
  worker.say(traced(job.scene, first));
  CHECK(worker.hear<msg::ResultVerdict>().verdict == msg::Verdict::stale);
}

TEST_CASE("a result counts once, and a repeated one is stale") {
  const Server server(quick());
  OneLease job;
  job.settings.schedule = SchedulePolicy::factoring;  // several leases: the job stays open
  Peer worker(server);
  worker.join("w");
  Peer client(server);
  client.submit(job.scene, job.settings);
  const auto result = traced(job.scene, worker.hear<msg::Grant>());
  worker.say(result);
  CHECK(worker.hear<msg::ResultVerdict>().verdict == msg::Verdict::accepted);
  worker.say(result);
  CHECK(worker.hear<msg::ResultVerdict>().verdict == msg::Verdict::stale);
}

TEST_CASE(
    "a result with other cells or samples than its lease is not merged, and its worker is faulty") {
  for (const bool cells : {true, false}) {
    const Server server(quick());
    OneLease job;
    Peer worker(server);
    worker.join("w");
    Peer client(server);
    client.submit(job.scene, job.settings);
    auto grant = worker.hear<msg::Grant>();
    if (cells) {
      --grant.cells.range.end;
    } else {
      GridShape shape = grant.cells.grid->shape();
      --shape.width;
      shape.cell_pixels = std::min(shape.cell_pixels, shape.width);
      grant.cells.grid = std::make_shared<const CellGrid>(shape);
    }
    worker.say(traced(job.scene, grant));
    CHECK(worker.hear<msg::ResultVerdict>().verdict == msg::Verdict::stale);
    client.say(msg::ListWorkers{5});
    CHECK(client.hear<msg::Workers>().workers[0]["state"] == "quarantined");
  }
}

TEST_CASE("a failed lease is acknowledged by revoke") {
  const Server server(quick());
  const OneLease job;
  Peer worker(server);
  worker.join("w");
  Peer client(server);
  const JobId id = client.submit(job.scene, job.settings);
  auto grant = worker.hear<msg::Grant>();
  for (int i = 0; i < 2; ++i) {
    worker.say(msg::Failed{grant.job, grant.epoch, "too large for this machine"});
    CHECK(worker.hear<msg::Revoke>().epoch == grant.epoch);
    if (i == 0) {
      grant = worker.hear<msg::Grant>();  // granted again, because there is no other worker
    }
  }
  client.say(msg::ShowJob{1, id});
  const auto shown = client.hear<msg::Job>().job;
  CHECK(shown["state"] == "failed");
  CHECK(shown["reason"].get<std::string>().find("too large for this machine") == 0);
}

TEST_CASE("the present state of a picture can be fetched before it is done") {
  const Server server(quick());
  OneLease job;
  job.settings.progressive = true;
  job.settings.schedule = SchedulePolicy::factoring;
  Peer worker(server);
  worker.join("w");
  Peer client(server);
  job.settings.width = 300;  // more than one lattice
  job.settings.height = 200;
  const JobId id = client.submit(job.scene, job.settings);
  client.say(msg::Fetch{1, id});
  CHECK(client.hear<msg::Error>().status == 2);
  const auto grant = worker.hear<msg::Grant>();
  // One sample of every pixel comes first.
  CHECK(grant.cells.grid->cell(grant.cells.range.begin).samples == SampleRange{0, 1});
  const auto result = traced(job.scene, grant);
  worker.say(result);
  worker.hear<msg::ResultVerdict>();
  client.say(msg::Fetch{2, id, true, false});
  const auto image = client.hear<msg::ImageData>();
  CHECK(image.report.at("partial") == true);
  CHECK(image.report.at("samples") == grant.cells.sample_count());
  // Fewer samples than pixels: the other pixels are filled, so that none is black in this scene.
  REQUIRE(grant.cells.sample_count() < 300 * 200);
  const auto picture = image.picture.picture(300, 200);
  const auto& rgb = picture->image.rgb;
  REQUIRE(rgb.size() == std::size_t{3} * 300 * 200);
  CHECK(std::count_if(rgb.begin(), rgb.end(), [](float value) { return value == 0; }) <
        static_cast<std::ptrdiff_t>(rgb.size() / 10));
}

TEST_CASE("workers of another protocol, trace version or arithmetic are refused with the reason") {
  const Server server(quick());
  const auto refusal = [&](const msg::Hello& hello) {
    Peer worker(server);
    worker.say(hello);
    return worker.hear<msg::Refuse>().reason;
  };
  CHECK(refusal({99, "w", "w", 1, 1, trace_version, "same"}).find("protocol version 99") == 0);
  CHECK(refusal({protocol_version, "w", "w", 1, 1, trace_version + 1, "same"})
            .find("trace version") == 0);
  CHECK(refusal({protocol_version, "w", "w", 1, 1, trace_version, "other"})
            .find("the worker's built-in test picture differs") == 0);
}

TEST_CASE("the coordinator asks an unknown worker to identify itself") {
  const Server server(quick());
  Peer worker(server);
  worker.say(msg::Heartbeat{});
  worker.hear<msg::Identify>();
}

TEST_CASE("a heartbeat that lists another worker's lease is answered by revoke") {
  const Server server(quick());
  Peer worker(server);
  worker.join("w");
  worker.say(msg::Heartbeat{1, false, {{7, 8}}});
  const auto revoke = worker.hear<msg::Revoke>();
  CHECK(revoke.job == 7);
  CHECK(revoke.epoch == 8);
}

TEST_CASE("malformed messages are dropped, a client's is answered, and the service continues") {
  const Server server(quick());
  Peer client(server);
  client.say_raw({std::string("not MessagePack")});
  client.say_raw({std::string(100000, '\x91')});  // arrays nested 100 000 deep
  client.say_raw({});
  msg::Submit submit;
  submit.request = 9;
  submit.token = "token";
  submit.name = "scene";
  submit.settings = small_settings(small_scene());
  submit.scene = ScenePayload(Bulk::of("bytes"));
  client.say(submit);
  const auto error = client.hear<msg::Error>();
  CHECK(error.request == 9);
  CHECK(error.status == 2);
  client.say(msg::ListJobs{10});
  CHECK(client.hear<msg::Jobs>().jobs.empty());
}

TEST_CASE("a message with too many frames is dropped as a whole, and the next one is read") {
  const Server server(quick());
  Peer speaker(server);
  Frames hello = encode(msg::Hello{protocol_version, "w", "w", 1, 1, trace_version, "same"});
  for (const std::size_t frames : std::initializer_list<std::size_t>{15, 16, 17, 32, 100'000}) {
    Frames many(frames, Frame(std::string("x")));
    many.back() = hello.front();  // no part of it is read as a message
    speaker.say_raw(many);
  }
  speaker.say(msg::ListWorkers{1});
  CHECK(speaker.hear<msg::Workers>().workers.empty());
  speaker.join("w");
}

TEST_CASE("a repeated submit makes no second job, and an invalid scene makes no job") {
  const Server server(quick());
  const OneLease job;
  Peer client(server);
  const JobId id = client.submit(job.scene, job.settings);
  CHECK(client.submit(job.scene, job.settings) == id);
  msg::Submit bad;
  bad.token = "another";
  bad.name = "bad";
  bad.settings = job.settings;
  bad.scene = ScenePayload(Bulk::of("no scene"));
  client.say(bad);
  CHECK(client.hear<msg::Error>().status == 2);
  client.say(msg::ListJobs{});
  CHECK(client.hear<msg::Jobs>().jobs.size() == 1);
}

TEST_CASE("a request for a missing job is refused with its number") {
  const Server server(quick());
  Peer client(server);
  for (const Message& request :
       {Message(msg::ShowJob{1, 5}), Message(msg::SteerJob{1, 5, msg::JobAction::cancel}),
        Message(msg::SteerJob{1, 5, msg::JobAction::pause}),
        Message(msg::SteerJob{1, 5, msg::JobAction::resume}), Message(msg::Fetch{1, 5})}) {
    client.say(request);
    const auto error = client.hear<msg::Error>();
    CHECK(error.status == 2);
    CHECK(error.message.find("no job 5") == 0);
  }
}

}  // namespace parray::test
