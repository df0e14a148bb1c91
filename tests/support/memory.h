#pragma once

#include <cstdint>
#include <fstream>
#include <limits>
#include <string>

#include "tests/support/rooms.h"

namespace parray::test {

/// Returns the largest address space of this process so far, in bytes. It includes allocated memory
/// that was never touched.
inline std::uint64_t peak_address_space() {
  std::ifstream status("/proc/self/status");
  std::string key;
  std::uint64_t kibibytes = 0;
  while (status >> key) {
    if (key == "VmPeak:" && status >> kibibytes) return kibibytes * 1024;
    status.ignore(std::numeric_limits<std::streamsize>::max(), '\n');
  }
  return 0;
}

}  // namespace parray::test
