#pragma once

#include <algorithm>

#include "common/scene/scene.h"

namespace parray::scene {

/// Returns the largest component of the sky's two colours. No sample has a larger radiance, because
/// no surface adds any. This number determines the fixed-point scale of sums
/// (common/image/radiance_scale.h).
inline double largest_radiance(const Sky& sky) {
  const Vec3d& a = sky.horizon;
  const Vec3d& b = sky.zenith;
  return std::max({a.x, a.y, a.z, b.x, b.y, b.z});
}
inline double largest_radiance(const Scene& scene) { return largest_radiance(scene.sky); }

}  // namespace parray::scene
