#pragma once

#include <algorithm>
#include <limits>

#include "common/rooms.h"

namespace parray::input {

/// The least and the largest of the numbers that were added. Empty before the first one.
struct NumberBounds {
  double low = std::numeric_limits<double>::infinity();
  double high = -std::numeric_limits<double>::infinity();

  void add(double value) {
    low = std::min(low, value);
    high = std::max(high, value);
  }
  void add(const NumberBounds& more) {
    low = std::min(low, more.low);
    high = std::max(high, more.high);
  }
  [[nodiscard]] bool empty() const { return low > high; }
  friend bool operator==(const NumberBounds&, const NumberBounds&) = default;
};

}  // namespace parray::input
