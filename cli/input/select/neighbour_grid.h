#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "common/math/vec.h"

namespace parray::input {

/// Points in cells of a regular grid, for the question whether one of them is near. Only cells that
/// hold points take memory, so a few far away do not matter.
class NeighbourGrid {
 public:
  /// `points` are finite; `distance` > 0.
  NeighbourGrid(const std::vector<Vec3d>& points, double distance);

  /// One of the points is not farther than the distance from `position`.
  [[nodiscard]] bool near(const Vec3d& position) const;

 private:
  using Key = std::uint64_t;
  struct Entry {
    Key key;
    Vec3d point;
  };
  [[nodiscard]] std::int64_t cell(double coordinate, double low) const;
  [[nodiscard]] bool near_in_row(const Vec3d& position, std::int64_t x, std::int64_t y,
                                 std::int64_t z) const;

  double square_;
  double edge_ = 1;
  Vec3d low_{};
  Vec3d high_{};
  std::vector<Entry> entries_;  // by key: cells along x follow each other
};

}  // namespace parray::input
