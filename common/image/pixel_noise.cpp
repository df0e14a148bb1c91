#include "common/image/pixel_noise.h"

#include <cmath>

namespace parray {

PixelNoise noise_of(const PixelSums& pixel, std::uint32_t count, const RadianceScale& scale) {
  PixelNoise noise;
  if (count < 2) {
    return noise;
  }
  const double odd_count = count / 2;
  const double even_count = count - count / 2;
  const double weight = std::sqrt(even_count * odd_count) / count;
  for (std::size_t channel = 0; channel < 3; ++channel) {
    const std::uint64_t sum = pixel.sum[channel];
    const std::uint64_t odd = pixel.odd[channel];
    const double mean = scale.mean(sum, count);
    const double spread = scale.mean_square(pixel.sum_of_squares[channel], count) - mean * mean;
    // Squares are stored rounded down: samples that are all alike may seem to have less than none.
    noise.variance[channel] = spread > 0 ? spread * count / (count - 1.0) : 0;
    const double even_mean = static_cast<double>(sum - odd) / even_count;
    const double odd_mean = static_cast<double>(odd) / odd_count;
    noise.difference[channel] = (even_mean - odd_mean) * weight * scale.mean(1, 1);
  }
  return noise;
}

}  // namespace parray
