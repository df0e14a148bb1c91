#pragma once

#include <cstdint>
#include <fstream>
#include <limits>
#include <string>

#include "tests/support/rooms.h"

namespace parray::test {

/// Most address space that this process has had at once, in bytes: grows with what is allocated,
/// touched or not.
inline std::uint64_t peak_address_space() {
  std::ifstream status("/proc/self/status");
  std::string key;
  std::uint64_t kibibytes = 0;
  while (status >> key) {
    if (key == "VmPeak:" && status >> kibibytes) {
      return kibibytes * 1024;
    }
    status.ignore(std::numeric_limits<std::streamsize>::max(), '\n');
  }
  return 0;
}

}  // namespace parray::test
