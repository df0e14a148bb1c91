#pragma once

#include <cstddef>
#include <cstring>
#include <string>

#include "tests/support/rooms.h"

namespace parray::test {

/// Returns `bytes` with the value at the offset `at` replaced.
template <typename T>
std::string with_value(std::string bytes, std::size_t at, T value) {
  std::memcpy(bytes.data() + at, &value, sizeof value);
  return bytes;
}

}  // namespace parray::test
