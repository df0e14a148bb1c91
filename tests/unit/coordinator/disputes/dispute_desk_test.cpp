#include <doctest/doctest.h>

#include <nlohmann/json.hpp>

#include "tests/support/farm_rig.h"
#include "tests/support/rooms.h"

namespace parray {
namespace {

using test::FarmRig;

TEST_CASE("a drained worker gets no leases until it is readmitted") {
  FarmRig rig;
  WorkerRecord& worker = rig.join("peer", "one");
  rig.disputes.drain("one", false, "a test");
  CHECK_FALSE(worker.may_trace());
  rig.disputes.readmit("one", false);
  CHECK(worker.may_trace());
}

TEST_CASE("a drained host also bars workers that join later") {
  FarmRig rig;
  rig.disputes.drain("host of late", true, "a test");
  CHECK_FALSE(rig.join("peer", "late").may_trace());
  CHECK(rig.join("other", "elsewhere").may_trace());
}

TEST_CASE("a machine in quarantine gets no leases, and is listed after its worker has left") {
  FarmRig rig;
  WorkerRecord& worker = rig.join("peer", "faulty");
  rig.disputes.quarantine(worker.machine_key, "in a test");
  CHECK_FALSE(worker.may_trace());
  CHECK(rig.disputes.quarantined_elsewhere().empty());
  CHECK(rig.disputes.latest_finding() > 0);
  rig.workers.lose_worker(rig.farm.now, "peer", "in a test", false);
  const auto listed = rig.disputes.quarantined_elsewhere();
  REQUIRE(listed.size() == 1);
  CHECK(listed[0].at("name") == "faulty");
  CHECK(listed[0].at("host") == "host of faulty");
  rig.disputes.readmit("host of faulty", true);
  CHECK(rig.disputes.quarantined_elsewhere().empty());
}

}  // namespace
}  // namespace parray
