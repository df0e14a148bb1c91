#pragma once

#include <algorithm>

#include "common/scene/scene.h"

namespace parray::scene {

/// Returns the largest radiance that a sample under this sky can have, because no surface adds
/// radiance. It determines the fixed-point scale of sums.
inline double largest_radiance(const Sky& sky) {
  const Vec3d& a = sky.horizon;
  const Vec3d& b = sky.zenith;
  return std::max({a.x, a.y, a.z, b.x, b.y, b.z});
}
inline double largest_radiance(const Scene& scene) { return largest_radiance(scene.sky); }

}  // namespace parray::scene
