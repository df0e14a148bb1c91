#include <doctest/doctest.h>

#include "tests/support/farm_rig.h"
#include "tests/support/rooms.h"

namespace parray {
namespace {

using test::FarmRig;

TEST_CASE("without workers no lease is granted") {
  FarmRig rig;
  rig.add_job(5);
  CHECK(rig.leases.grant_leases(rig.farm.now));
  CHECK(rig.farm.tally.granted == 0);
  CHECK(rig.leases.next_deadline() == never);
}

TEST_CASE("a result of a lease that does not exist is stale") {
  FarmRig rig;
  rig.join("peer", "one");
  rig.sent<msg::Welcome>();
  msg::Result result;
  result.job = 5;
  result.epoch = 3;
  rig.leases.on(rig.farm.now, "peer", result);
  const auto verdicts = rig.sent<msg::ResultVerdict>();
  REQUIRE(verdicts.size() == 1);
  CHECK(verdicts[0].verdict == msg::Verdict::stale);
  CHECK(rig.farm.tally.stale == 1);
}

TEST_CASE("a result of an unknown worker is ignored") {
  FarmRig rig;
  msg::Result result;
  rig.leases.on(rig.farm.now, "stranger", result);
  CHECK(rig.farm.tally.stale == 0);
  CHECK(rig.sent<msg::Identify>().size() == 1);
}

TEST_CASE("a failure of a lease that has no holder changes nothing") {
  FarmRig rig;
  rig.join("peer", "one");
  rig.add_job(5);
  msg::Failed failed;
  failed.job = 5;
  rig.leases.on(rig.farm.now, "peer", failed);
  CHECK(rig.farm.tally.failed == 0);
  CHECK(rig.sent<msg::Revoke>().size() == 1);
}

}  // namespace
}  // namespace parray
