#pragma once

#include "common/math/lanes.h"

/// Lanes of any processor, as many as fit its compiler's vectors.
namespace parray::math::scalar {

using FloatLanes = Lanes<float, 4>;
using DoubleLanes = Lanes<double, 4>;

}  // namespace parray::math::scalar
