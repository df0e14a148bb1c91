#include "common/image/pixel_noise.h"

#include <algorithm>
#include <cmath>

namespace parray {

PixelNoise noise_of(const PixelSums& pixel, std::uint32_t count, const RadianceScale& scale) {
  PixelNoise noise;
  if (count < 2) {
    return noise;
  }
  const double odds = count / 2;
  const double evens = count - odds;
  const double unit = scale.mean(1, 1);
  const double per_sample = 1.0 / count;
  const double unbiased = count / (count - 1.0);
  const double weight = unit / (count * std::sqrt(evens * odds));
  for (std::size_t channel = 0; channel < 3; ++channel) {
    const auto sum = static_cast<double>(pixel.sum[channel]);
    const auto odd = static_cast<double>(pixel.odd[channel]);
    const auto even = static_cast<double>(pixel.sum[channel] - pixel.odd[channel]);
    const double mean = sum * per_sample * unit;
    const double square = scale.mean_square(pixel.sum_of_squares[channel], 1) * per_sample;
    // Squares are stored rounded down: samples that are all alike may seem to have less than none.
    noise.variance[channel] = std::max(0.0, (square - mean * mean) * unbiased);
    noise.mean[channel] = mean;
    noise.difference[channel] = (even * odds - odd * evens) * weight;
  }
  return noise;
}

}  // namespace parray
