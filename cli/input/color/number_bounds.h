#pragma once

#include <algorithm>
#include <limits>
#include <span>

#include "common/math/vec.h"

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

/// The bounds of positions along the axes.
struct PositionBounds {
  Vec3d low;
  Vec3d high = low;

  void add(const Vec3d& p) {
    low = {std::min(low.x, p.x), std::min(low.y, p.y), std::min(low.z, p.z)};
    high = {std::max(high.x, p.x), std::max(high.y, p.y), std::max(high.z, p.z)};
  }
};
/// `positions`: not empty.
inline PositionBounds bounds_of(std::span<const Vec3d> positions) {
  PositionBounds bounds{positions.front()};
  for (const Vec3d& p : positions) bounds.add(p);
  return bounds;
}

}  // namespace parray::input
