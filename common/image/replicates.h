#pragma once

#include <array>
#include <vector>

#include "common/rooms.h"

namespace parray::image {

/// The two halves of a picture's samples, those with even and those with odd numbers: independent
/// pictures of the same scene, which differ by noise alone. Pixels by image row.
struct Replicates {
  /// Linear radiance, 3 values (R, G, B) a pixel: of the even half, of the odd half.
  std::array<std::vector<float>, 2> mean;
  /// One value a pixel: the root mean square error, over the channels, that a half is expected to
  /// have there, by the samples of the pixels around it. The pixel's own samples have no say, but
  /// for one factor of the whole picture.
  std::vector<float> noise;

  [[nodiscard]] bool empty() const { return noise.empty(); }
};

}  // namespace parray::image
