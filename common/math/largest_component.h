#pragma once

#include <algorithm>
#include <cmath>

#include "common/math/vec.h"

namespace parray::math {

/// Returns the largest magnitude of the components.
template <typename Real>
Real largest_component(const Vec3<Real>& v) {
  return std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)});
}

}  // namespace parray::math
