#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "common/trace/ray.h"

namespace parray::trace {

/// Which side of every sphere a path is on: the spheres that it is inside of, and the one whose
/// surface it stands on.
///
/// Material events change it (a refraction flips a side, nothing else does); no sign of a computed
/// distance ever does. That is why a path can neither hit the surface it leaves nor leak out of a
/// closed sphere, whatever the rounding. One path at a time; not thread-safe.
template <typename Real>
class InsideStack {
 public:
  /// Begins a path in free space, inside the given spheres.
  void start(const std::vector<std::uint32_t>& inside) {
    inside_.assign(inside.begin(), inside.end());
    surface_ = no_sphere;
  }

  /// Puts the path on a sphere's surface, at its outward unit normal.
  void stand_on(std::uint32_t sphere, const Vec3<Real>& normal) {
    surface_ = sphere;
    normal_ = normal;
  }

  /// The path passes through the surface of `sphere`.
  void cross(std::uint32_t sphere, bool leaving) {
    if (leaving) {
      inside_.erase(std::find(inside_.begin(), inside_.end(), sphere));
    } else {
      inside_.push_back(sphere);
    }
  }

  [[nodiscard]] const std::vector<std::uint32_t>& inside() const { return inside_; }
  [[nodiscard]] bool stands_on(std::uint32_t sphere) const { return sphere == surface_; }
  [[nodiscard]] const Vec3<Real>& normal() const { return normal_; }

  /// True for a sphere that the path cannot enter: it is inside already, or stands on its outside,
  /// and a convex body cannot be met by a ray that leaves it.
  [[nodiscard]] bool cannot_enter(std::uint32_t sphere) const {
    return sphere == surface_ || std::find(inside_.begin(), inside_.end(), sphere) != inside_.end();
  }

 private:
  std::vector<std::uint32_t> inside_;
  std::uint32_t surface_ = no_sphere;
  Vec3<Real> normal_{};
};

}  // namespace parray::trace
