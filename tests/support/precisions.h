#pragma once

#include <array>

#include "common/scene/settings.h"
#include "tests/support/rooms.h"

namespace parray::test {

inline constexpr std::array precisions{Precision::f32, Precision::mixed, Precision::f64};
inline constexpr std::array accelerators{AcceleratorKind::linear, AcceleratorKind::bvh,
                                         AcceleratorKind::octree};

}  // namespace parray::test
