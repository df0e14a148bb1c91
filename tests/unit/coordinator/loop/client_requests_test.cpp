#include <doctest/doctest.h>

#include <nlohmann/json.hpp>

#include "tests/support/farm_rig.h"
#include "tests/support/rooms.h"

namespace parray {
namespace {

using test::FarmRig;

TEST_CASE("a request about an unknown job is answered with status 2") {
  FarmRig rig;
  msg::ShowJob m{1, 5};
  rig.clients.on(rig.farm.now, "client", m);
  const auto errors = rig.sent<msg::Error>();
  REQUIRE(errors.size() == 1);
  CHECK(errors[0].status == 2);
  CHECK(errors[0].message.find("no job 5") != std::string::npos);
}

TEST_CASE("only an administrator may change the job of another user") {
  FarmRig rig;
  Job& job = rig.add_job(5, "ann");
  rig.farm.sender = {Role::client, "bob"};
  msg::SteerJob pause{1, 5, msg::JobAction::pause, 50};
  rig.clients.on(rig.farm.now, "client", pause);
  CHECK(rig.sent<msg::Error>().size() == 1);
  CHECK(job.record.state == JobState::queued);

  rig.farm.sender = {Role::admin, "carol"};
  rig.clients.on(rig.farm.now, "client", pause);
  CHECK(rig.sent<msg::Job>().size() == 1);
  CHECK(job.record.state == JobState::paused);
}

TEST_CASE("a client may not drain workers") {
  FarmRig rig;
  WorkerRecord& worker = rig.join("peer", "one");
  rig.farm.sender = {Role::client, "bob"};
  msg::SteerWorkers drain{1, msg::WorkerAction::drain, false, "one"};
  rig.clients.on(rig.farm.now, "client", drain);
  CHECK(rig.sent<msg::Error>().size() == 1);
  CHECK(worker.may_trace());

  rig.farm.sender = {Role::admin, "carol"};
  rig.clients.on(rig.farm.now, "client", drain);
  CHECK_FALSE(worker.may_trace());
}

TEST_CASE("a fetch of an unfinished picture is refused") {
  FarmRig rig;
  rig.add_job(5);
  msg::Fetch m{1, 5, false, false};
  rig.clients.on(rig.farm.now, "client", m);
  const auto errors = rig.sent<msg::Error>();
  REQUIRE(errors.size() == 1);
  CHECK(errors[0].message.find("queued, not done") != std::string::npos);
}

}  // namespace
}  // namespace parray
