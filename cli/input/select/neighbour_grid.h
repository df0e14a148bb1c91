#pragma once

#include <cstdint>
#include <vector>

#include "common/math/vec.h"

namespace parray::input {

/// Stores points in the cells of a regular grid and finds out whether a point is close to a
/// position. Only cells with points take memory.
class NeighbourGrid {
 public:
  /// `points` are finite; `distance` > 0.
  NeighbourGrid(const std::vector<Vec3d>& points, double distance);

  /// Returns whether a point is at most `distance` away from `position`.
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
  std::vector<Entry> entries_;  // sorted by key: cells along x are adjacent
};

}  // namespace parray::input
