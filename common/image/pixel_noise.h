#pragma once

#include <array>
#include <cstdint>

#include "common/image/pixel_sums.h"
#include "common/image/radiance_scale.h"

namespace parray {

/// What a pixel's own samples say about its noise, by channel.
struct PixelNoise {
  /// Of one sample, unbiased, in squared radiance; >= 0.
  std::array<double, 3> variance{};
  /// Of the means of the two replicates, scaled so that its mean square is that of the error of the
  /// pixel's mean, whatever the sampler; in radiance.
  std::array<double, 3> difference{};
};

/// Of a pixel with `count` >= 2 samples. With a and b samples of even and odd numbers, the error of
/// the mean has variance V/a = V/b (a = b) halved, and so has (A - B) sqrt(ab) / (a + b).
/// Arithmetic that is the same everywhere.
PixelNoise noise_of(const PixelSums& pixel, std::uint32_t count, const RadianceScale& scale);

}  // namespace parray
