#include "coordinator/loop/backoff.h"

#include <doctest/doctest.h>

#include "tests/support/rooms.h"

namespace parray {
namespace {

const MachineId sick_machine{MachineId::Kind::address, "10.0.0.1"};
const MachineId other_machine{MachineId::Kind::address, "10.0.0.2"};

}  // namespace

TEST_CASE("a worker that fails where others succeed gets no leases for 1, 2, 4 ... 64 minutes") {
  Backoff backoff;
  Time now = seconds(1000);
  Time length = seconds(60);
  for (int times = 0; times < 10; ++times) {
    backoff.note_failure(now, sick_machine, "ann", false);
    CHECK(backoff.until(sick_machine, "ann") == now + length);
    // A lease that it still held.
    backoff.note_failure(now + seconds(1), sick_machine, "ann", false);
    CHECK(backoff.until(sick_machine, "ann") == now + length);
    CHECK(backoff.until(sick_machine, "bob") <= now);
    CHECK(backoff.until(other_machine, "ann") <= now);
    now += length;
    length = std::min(2 * length, Time(seconds(64 * 60)));
  }
  CHECK(backoff.note_success(sick_machine, "ann"));
  CHECK_FALSE(backoff.note_success(sick_machine, "ann"));
  backoff.note_failure(now, sick_machine, "ann", false);
  CHECK(backoff.until(sick_machine, "ann") == now + seconds(60));
}

TEST_CASE("if no worker of a machine succeeds, the delay applies to every name there") {
  Backoff backoff;
  backoff.note_failure(seconds(1000), sick_machine, "vm-1", true);
  CHECK(backoff.until(sick_machine, "vm-2") == seconds(1060));
  backoff.note_failure(seconds(1060), sick_machine, "vm-2", true);
  CHECK(backoff.until(sick_machine, "vm-3") == seconds(1180));
  CHECK(backoff.forgive(sick_machine, "vm-3"));
  CHECK(backoff.until(sick_machine, "vm-1") <= seconds(1000));
}

}  // namespace parray
