#pragma once

#include <cstdint>

#include "common/rooms.h"

namespace parray::scene {

// Both ends belong to a range.
struct NumberRange {
  double least;
  double most;
};
struct IntegerRange {
  std::uint64_t least;
  std::uint64_t most;
};

}  // namespace parray::scene
