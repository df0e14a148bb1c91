#include "tests/experiments/simulation/costs.h"

#include "common/base/error.h"
#include "tests/support/rooms.h"

namespace parray::simulation {

const std::vector<LinkCosts>& known_links() {
  static const std::vector<LinkCosts> links = {
      {.name = "infiniband",
       .origin = "assumed: 2 us latency, 12.5 GB/s, 2.5 M atomics/s on one word",
       .atomic = 4e-6,  // there and back
       .atomic_service = 0.4e-6,
       .put = 4e-6,
       .bytes_per_second = 12.5e9,
       .own_atomic = 0.1e-6,
       .own_bytes_per_second = 5e9,
       .needs_target = false},
      {.name = "shared-memory",
       .origin = "measured by tests/bench/window-latency between two ranks of one machine",
       .atomic = 0.11e-6,
       .atomic_service = 0.05e-6,  // of it, a guess
       .put = 0.06e-6,
       .bytes_per_second = 30e9,
       .own_atomic = 0.1e-6,
       .own_bytes_per_second = 5e9,
       .needs_target = false},
      {.name = "tcp",
       .origin = "measured between two network namespaces, rank 0 looking every 50 us",
       .atomic = 85e-6,
       .atomic_service = 1e-6,
       .put = 85e-6,
       .bytes_per_second = 1e9,
       .own_atomic = 0.1e-6,
       .own_bytes_per_second = 5e9,
       .needs_target = true},
      {.name = "messages",
       .origin = "measured by tests/bench/window-latency: each operation is a request to rank 0",
       .atomic = 57e-6,  // a lease is three operations, 169 us together
       .atomic_service = 1e-6,
       .put = 57e-6,  // a result is two puts, 114 us together
       .bytes_per_second = 5e9,
       .own_atomic = 0.1e-6,
       .own_bytes_per_second = 5e9,
       .needs_target = true}};
  return links;
}

const LinkCosts& link_from(std::string_view name) {
  std::string names;
  for (const LinkCosts& link : known_links()) {
    if (link.name == name) return link;
    names += (names.empty() ? "" : ", ") + link.name;
  }
  throw InputError("no link is called '" + std::string(name) + "'; known: " + names);
}

}  // namespace parray::simulation
