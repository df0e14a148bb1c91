#include "common/image/error_estimate.h"

#include <algorithm>
#include <cmath>

#include "common/image/pixel_noise.h"

namespace parray {
namespace {

constexpr double normal_95 = 1.959964;  ///< half the width of a normal's 95 % interval

bool all_have_two(const PictureState& state) {
  return !state.counts.empty() &&
         std::all_of(state.counts.begin(), state.counts.end(), [](auto n) { return n >= 2; });
}

float quantile(std::vector<float> values, double share) {
  const auto at =
      values.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

}  // namespace

ErrorEstimate estimate_error(const PictureState& state) {
  ErrorEstimate error;
  if (!all_have_two(state)) {
    return error;
  }
  const RadianceScale scale(state.largest_radiance);
  error.half_width.reserve(state.pixels.size() * 3);
  double squares = 0;
  double scatter = 0;
  for (std::size_t i = 0; i < state.pixels.size(); ++i) {
    const PixelNoise noise = noise_of(state.pixels[i], state.counts[i], scale);
    double of_pixel = 0;
    for (std::size_t channel = 0; channel < 3; ++channel) {
      of_pixel += noise.difference[channel] * noise.difference[channel] / 3;
      error.half_width.push_back(
          static_cast<float>(normal_95 * std::sqrt(noise.variance[channel] / state.counts[i])));
    }
    squares += of_pixel;
    scatter += of_pixel * of_pixel * 4 / 3;
  }
  const double size = static_cast<double>(state.pixels.size());
  error.rmse = std::sqrt(squares / size);
  const double relative = squares > 0 ? normal_95 * std::sqrt(scatter) / squares : 0;
  const double factor = std::sqrt(1 + relative + relative * relative / 2);
  error.low = error.rmse / factor;
  error.high = error.rmse * factor;
  error.half_width_p50 = quantile(error.half_width, 0.5);
  error.half_width_p99 = quantile(error.half_width, 0.99);
  return error;
}

}  // namespace parray
