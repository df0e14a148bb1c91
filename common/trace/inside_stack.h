#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "common/trace/ray.h"

namespace parray::trace {

/// Tracks the side of every shape that a path is on: the shapes that the path is inside of, and
/// the shape that it stands on.
///
/// Only material events change the sides: a refraction flips one, and nothing else does. The sign
/// of a computed distance never changes a side. So rounding can neither make a path hit the surface
/// that it leaves nor let it leak out of a closed shape. Serves one path at a time; not
/// thread-safe.
///
/// Bodies of the same glass that overlap are one body: a path goes straight on through a surface
/// that lies inside another body of its own material. These crossings do not count as segments of
/// the path, except for each one after most_crossings others. So tracing ends even if thousands of
/// bodies overlap.
template <typename Real>
class InsideStack {
 public:
  /// Begins a path that stands on no surface. `inside` lists the shapes that contain its origin.
  void start(const std::vector<std::uint32_t>& inside) {
    inside_.assign(inside.begin(), inside.end());
    surface_ = no_shape;
  }

  /// Puts the path on a shape's surface, at the point with this outward unit normal. Does not
  /// change the shapes that the path is inside of.
  void stand_on(std::uint32_t shape, const Vec3<Real>& normal) {
    surface_ = shape;
    normal_ = normal;
  }

  /// Moves the path through the surface of `shape`: out of it if `leaving`, otherwise into it. A
  /// path that leaves must be inside of the shape.
  void cross(std::uint32_t shape, bool leaving) {
    if (leaving) {
      inside_.erase(std::find(inside_.begin(), inside_.end(), shape));
    } else {
      inside_.push_back(shape);
    }
  }

  /// Returns the shapes that the path is inside of, in the order in which it entered them.
  [[nodiscard]] const std::vector<std::uint32_t>& inside() const { return inside_; }
  [[nodiscard]] bool stands_on(std::uint32_t shape) const { return shape == surface_; }
  /// Returns the normal of the last stand_on(). Has no meaning before that.
  [[nodiscard]] const Vec3<Real>& normal() const { return normal_; }

  /// Returns whether the path cannot enter a shape. That is so if the path is inside already, or
  /// stands on its outside: a ray that leaves a convex body cannot meet it again.
  [[nodiscard]] bool cannot_enter(std::uint32_t shape) const {
    return shape == surface_ || std::find(inside_.begin(), inside_.end(), shape) != inside_.end();
  }

 private:
  std::vector<std::uint32_t> inside_;
  std::uint32_t surface_ = no_shape;
  Vec3<Real> normal_{};
};

}  // namespace parray::trace
