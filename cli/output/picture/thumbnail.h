#pragma once

#include <cstdint>

#include "common/image/image.h"

namespace parray::picture {

/// Returns a smaller copy of the picture with its proportions, `width` (>= 1) pixels wide. The
/// height is rounded to the nearest number of pixels, at least one. Each pixel is the mean of the
/// linear values of the area that it covers. A picture that is not wider than `width` keeps its
/// size.
Image thumbnail(const Image& image, std::uint32_t width);

}  // namespace parray::picture
