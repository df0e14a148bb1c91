#include <doctest/doctest.h>

#include "tests/support/farm_rig.h"
#include "tests/support/rooms.h"

namespace parray {
namespace {

using test::FarmRig;

TEST_CASE("a worker with another protocol version is refused; the message names the remedy") {
  FarmRig rig;
  msg::Hello old = FarmRig::hello("old");
  old.version = protocol_version + 1;
  rig.workers.on(rig.farm.now, "peer", old);
  const auto refusals = rig.sent<msg::Refuse>();
  REQUIRE(refusals.size() == 1);
  CHECK(refusals[0].reason.find("install the same release on both") != std::string::npos);
  CHECK(rig.farm.workers.size() == 0);
}

TEST_CASE("a worker whose test picture differs is refused") {
  FarmRig rig;
  msg::Hello other = FarmRig::hello("other");
  other.fingerprint = "different";
  rig.workers.on(rig.farm.now, "peer", other);
  CHECK(rig.sent<msg::Refuse>().size() == 1);
  CHECK(rig.farm.workers.size() == 0);
}

TEST_CASE("a worker that joins gets a welcome, and leases are granted next") {
  FarmRig rig;
  rig.farm.grants_due = false;
  rig.join("peer", "one");
  CHECK(rig.sent<msg::Welcome>().size() == 1);
  CHECK(rig.farm.grants_due);
  CHECK(rig.farm.machines.find(rig.farm.workers.at("peer")->machine_key).worker == "one");
}

TEST_CASE("at most --max-workers workers may join") {
  CoordinatorOptions options = FarmRig::rig_options();
  options.max_workers = 1;
  FarmRig rig(options);
  rig.join("a", "one");
  msg::Hello second = FarmRig::hello("two");
  rig.workers.on(rig.farm.now, "b", second);
  CHECK(rig.farm.workers.at("b") == nullptr);
  CHECK(rig.sent<msg::Refuse>().size() == 1);
}

TEST_CASE("a heartbeat of an unknown worker is answered with identify") {
  FarmRig rig;
  msg::Heartbeat beat;
  rig.workers.on(rig.farm.now, "stranger", beat);
  CHECK(rig.sent<msg::Identify>().size() == 1);
}

TEST_CASE("a heartbeat that names a lease without a holder is answered with revoke") {
  FarmRig rig;
  rig.join("peer", "one");
  rig.sent<msg::Welcome>();
  msg::Heartbeat beat;
  beat.epochs.emplace_back(7, 9);
  rig.workers.on(rig.farm.now, "peer", beat);
  const auto revoked = rig.sent<msg::Revoke>();
  REQUIRE(revoked.size() == 1);
  CHECK(revoked[0].job == 7);
}

}  // namespace
}  // namespace parray
