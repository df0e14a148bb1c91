#pragma once

#include "common/math/vec.h"

namespace parray::input {

/// Linear RGB of an 8-bit sRGB colour, by the exact curve (cli/output/picture/srgb.h). Components
/// are whole numbers from 0 to 255.
Vec3d linear_of_srgb8(const Vec3d& color);

}  // namespace parray::input
