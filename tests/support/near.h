#pragma once

#include "common/math/vec.h"
#include "tests/support/rooms.h"

namespace parray::test {

/// Returns whether two vectors differ by rounding only.
inline bool near(const Vec3d& a, const Vec3d& b) { return length(a - b) < 1e-12; }

}  // namespace parray::test
