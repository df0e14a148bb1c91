#pragma once

#include <cstdint>

#include "common/image/image.h"

namespace parray::picture {

/// Returns a smaller copy of the picture with its proportions, `width` pixels wide, at least one
/// pixel high. Each of its pixels is the mean of the linear values of the area that it covers.
/// Returns a copy of a picture that is not wider than `width` (>= 1).
Image thumbnail(const Image& image, std::uint32_t width);

}  // namespace parray::picture
