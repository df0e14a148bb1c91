#pragma once

#include <array>
#include <vector>

#include "common/rooms.h"

namespace parray::image {

/// The two halves of a picture's samples, with even and with odd numbers. They are independent
/// pictures of the same scene that differ only in noise. Pixels are stored by image row.
struct Replicates {
  /// Linear radiance of the even half and of the odd half, 3 values (R, G, B) per pixel.
  std::array<std::vector<float>, 2> mean;
  /// Expected root mean square error of one half over the channels, in linear radiance, one value
  /// per pixel; 0 for all pixels: unknown. It comes from the samples of the surrounding pixels. The
  /// pixel's own samples enter only through one factor that is the same for the whole picture.
  std::vector<float> noise;

  [[nodiscard]] bool empty() const { return noise.empty(); }
};

}  // namespace parray::image
