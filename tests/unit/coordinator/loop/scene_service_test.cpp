#include "coordinator/loop/scene_service.h"

#include <doctest/doctest.h>

#include <map>
#include <set>
#include <string>

#include "tests/support/rooms.h"

namespace parray {
namespace {

const std::string scene_id(64, 'a');

WorkerRecord worker_on(WorkerId id, const std::string& host, const std::string& address,
                       std::uint32_t port = 7401) {
  WorkerRecord record;
  record.id = id;
  record.address = address;
  record.hello.host = host;
  record.hello.share_port = port;
  record.hello.share_key = "key " + std::to_string(id);
  return record;
}

/// Worker `id` of a machine of its own.
WorkerRecord single(WorkerId id) {
  return worker_on(id, "h" + std::to_string(id), "10.0.0." + std::to_string(id));
}

WorkerId ask(SceneService& service, const WorkerRecord& record, std::uint32_t failed = 0) {
  const auto answer = service.source_for(record, scene_id, 1000, failed);
  CHECK(answer.address.empty() == (service.source_of(record.id, scene_id) == 0));
  return service.source_of(record.id, scene_id);
}

}  // namespace

TEST_CASE("a source serves at most two workers, all of which asked later than it") {
  SceneService service;
  std::map<WorkerId, int> served;
  for (WorkerId id = 1; id <= 200; ++id) {
    const WorkerId source = ask(service, single(id));
    CHECK(source < id);
    CHECK(++served[source] <= 2);
    CHECK(ask(service, single(id)) == source);  // a repeated request gets the same answer
  }
}

TEST_CASE("a scene is sent to a machine once, and its workers share it there") {
  SceneService service;
  std::map<std::string, int> from_outside;
  for (WorkerId id = 1; id <= 60; ++id) {
    const std::string number = std::to_string(id % 5);
    const WorkerRecord record = worker_on(id, "h" + number, "10.0.0." + number);
    const WorkerId source = ask(service, record);
    from_outside["h" + number] += source == 0 || source % 5 != id % 5 ? 1 : 0;
  }
  for (const auto& machine : from_outside) {
    CAPTURE(machine.first);
    CHECK(machine.second == 1);
  }
}

TEST_CASE("two addresses with the same host name are two machines") {
  SceneService service;
  CHECK(ask(service, worker_on(1, "localhost", "10.0.0.1")) == 0);
  CHECK(ask(service, worker_on(2, "localhost", "10.0.0.2")) == 0);
  CHECK(ask(service, worker_on(3, "localhost", "10.0.0.2")) == 2);
}

TEST_CASE("a loopback worker serves only its machine; a worker that does not share serves none") {
  SceneService service;
  CHECK(ask(service, worker_on(1, "h1", "127.0.0.1")) == 0);
  CHECK(ask(service, worker_on(2, "h2", "10.0.0.2", 0)) == 0);
  CHECK(ask(service, worker_on(3, "h3", "10.0.0.3")) == 0);  // no other source may serve it
  CHECK(ask(service, worker_on(4, "h4", "10.0.0.4")) == 3);
  CHECK(ask(service, worker_on(5, "h5", "10.0.0.5", 0)) ==
        0);  // without a port it could not verify its source
  CHECK(ask(service, worker_on(6, "h1", "127.0.0.1")) == 1);
}

TEST_CASE("a failed source is replaced, in the end by the coordinator") {
  SceneService service;
  for (WorkerId id = 1; id <= 10; ++id) ask(service, single(id));
  const WorkerRecord child = single(10);
  std::set<WorkerId> tried{ask(service, child)};
  CHECK(*tried.begin() != 0);
  for (std::uint32_t failed = 1; failed < 3; ++failed) {
    const WorkerId next = ask(service, child, failed);
    CHECK(next < 10);
    CHECK((next == 0 || tried.insert(next).second));
    CHECK(ask(service, child, failed) == next);
  }
  CHECK(ask(service, child, 3) == 0);
  CHECK(ask(service, child, msg::every_source) == 0);
}

TEST_CASE("a source that failed for two workers serves no others") {
  SceneService service;
  for (WorkerId id = 1; id <= 4; ++id) {
    ask(service, single(id));  // 1 and 2 are served by the coordinator, 3 and 4 by 1
  }
  REQUIRE(ask(service, single(4)) == 1);
  ask(service, single(3), 1);
  ask(service, single(4), 1);
  for (WorkerId id = 5; id <= 30; ++id) CHECK(ask(service, single(id)) != 1);
}

TEST_CASE("a worker whose source left gets another, and the place of that source is free") {
  SceneService service;
  for (WorkerId id = 1; id <= 30; ++id) ask(service, single(id));
  service.forget_worker(1);
  service.forget_worker(5);
  std::map<WorkerId, int> served;
  for (WorkerId id = 2; id <= 30; ++id) {
    if (id == 5) continue;
    const WorkerId source = ask(service, single(id), 1);
    CHECK(source < id);
    CHECK(source != 1);
    CHECK(source != 5);
    ++served[source];
  }
}

TEST_CASE("chunk() returns the output of pack_chunk() and counts the bytes sent") {
  SceneService service(256);
  std::string bytes(600, 'x');
  const Frame frame(bytes);
  REQUIRE(service.chunk(scene_id, frame, 2));
  CHECK_FALSE(service.chunk(scene_id, frame, 3));
  const auto chunk = *service.chunk(scene_id, frame, 0);
  CHECK(chunk.packed);
  std::string unpacked(256, '\0');
  unpack_chunk(chunk.content.verified(), unpacked);
  CHECK(unpacked == bytes.substr(0, 256));
  ask(service, single(1));
  const auto spread = service.forget_scene(scene_id);
  CHECK(spread.workers == 1);
  CHECK(spread.bytes ==
        service.chunk(scene_id, frame, 2)->content.data.size() + chunk.content.data.size());
  CHECK(service.forget_scene(std::string(64, 'b')).workers == 0);
}

}  // namespace parray
