#pragma once

#include <cstdint>

namespace parray {

// Both ends belong to a range.
struct NumberRange {
  double least;
  double most;
};
struct IntegerRange {
  std::uint64_t least;
  std::uint64_t most;
};

}  // namespace parray
