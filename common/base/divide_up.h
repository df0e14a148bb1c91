#pragma once

#include <cstdint>

#include "common/rooms.h"

namespace parray::base {

/// Returns a / b, rounded up; b > 0. No intermediate result overflows.
constexpr std::uint64_t divide_up(std::uint64_t a, std::uint64_t b) {
  return a / b + (a % b != 0 ? 1 : 0);
}

}  // namespace parray::base
