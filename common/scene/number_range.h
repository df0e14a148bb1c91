#pragma once

#include <cstdint>

#include "common/rooms.h"

namespace parray::scene {

// Ranges include both ends.
struct NumberRange {
  double least;
  double most;
};
struct IntegerRange {
  std::uint64_t least;
  std::uint64_t most;
};

}  // namespace parray::scene
