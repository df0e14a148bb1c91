#include "coordinator/http/events.h"

#include <doctest/doctest.h>

#include <cstdint>

#include "coordinator/http/loop_client.h"
#include "tests/support/memory.h"
#include "tests/support/rooms.h"

namespace parray::http {

TEST_CASE("deleted jobs take no memory while no client listens") {
  InprocHub hub;
  LoopClient client(hub);
  Events events(client, 10);
  const std::uint64_t before = test::peak_address_space();
  for (JobId job = 0; job < 8'000'000; ++job) events.forgotten(job);
  CHECK(test::peak_address_space() - before < std::uint64_t{16} << 20);
}

}  // namespace parray::http
