#include "common/adaptive/error_intervals.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "common/adaptive/pixel_noise.h"

namespace parray {
namespace {

/// Half differences of replicates, with what the variance of the mean square needs.
struct Differences {
  std::vector<double> value;   ///< 3 a pixel, image order
  double squares = 0;          ///< sum
  double variances = 0;        ///< sum, of means
  double by_own_variance = 0;  ///< sum over pixels: square times variance, channels alike
};

Differences differences_of(const FramebufferView& state) {
  Differences all;
  all.value.reserve(3 * state.pixels.size());
  NoiseRows rows(state, NeighbourhoodSize::neighbours);
  for (std::size_t y = 0; y < state.height; ++y) {
    const NoiseRow row = rows.own(y);
    for (std::size_t i = 0; i < row.count.size(); i += 3) {
      double square = 0;
      double variance = 0;
      for (std::size_t value = i; value < i + 3; ++value) {
        all.value.push_back(row.difference[value]);
        square += row.difference[value] * row.difference[value];
        variance += row.variance[value] / row.count[i];
      }
      all.squares += square;
      all.variances += variance;
      all.by_own_variance += square * variance;
    }
  }
  return all;
}

/// Sum over pixels of the squared product of two neighbours' differences, as pairs side by side and
/// one below the other have it in the mean.
double by_neighbours(const std::vector<double>& difference, std::size_t width, std::size_t height) {
  double sum = 0;
  double pairs = 0;
  const auto add = [&](std::size_t pixel, std::size_t other) {
    double product = 0;
    for (std::size_t c = 0; c < 3; ++c) {
      product += difference[3 * pixel + c] * difference[3 * other + c];
    }
    sum += product * product;
    pairs += 1;
  };
  for (std::size_t y = 0; y < height; ++y) {
    for (std::size_t x = 0; x < width; ++x) {
      const std::size_t pixel = y * width + x;
      if (x + 1 < width) add(pixel, pixel + 1);
      if (y + 1 < height) add(pixel, pixel + width);
    }
  }
  return pairs > 0 ? sum / pairs * static_cast<double>(width * height) : 0;
}

}  // namespace

ErrorIntervals::ErrorIntervals(const FramebufferView& state, const ErrorEstimate& error) {
  const Differences all = differences_of(state);
  std::vector<double> ratios;
  for (std::size_t i = 0; i < all.value.size(); ++i) {
    if (all.value[i] != 0) ratios.push_back(std::abs(all.value[i]) / error.half_width[i]);
  }
  const double gain = all.variances > 0 ? all.squares / all.variances : 0;
  const double high = 4 * all.by_own_variance * gain;
  const double low = 4 * by_neighbours(all.value, state.width, state.height);
  const double deviation = all.squares > 0 ? std::sqrt(std::sqrt(low * high)) / all.squares : 0;
  for (std::size_t level = 0; level < interval_levels.size(); ++level) {
    const double normal = normal_half_widths[level] / normal_half_widths[stated_level];
    scales_[level] = normal;
    rmse_[level] = {error.rmse - normal * (error.rmse - error.low),
                    error.rmse + normal * (error.high - error.rmse)};
    if (level >= stated_level) continue;
    if (!ratios.empty()) {
      const auto rank = static_cast<std::ptrdiff_t>(interval_levels[level] *
                                                    static_cast<double>(ratios.size() - 1));
      std::nth_element(ratios.begin(), ratios.begin() + rank, ratios.end());
      scales_[level] = ratios[static_cast<std::size_t>(rank)];
    }
    // e^relative, nearly, as the stated interval.
    const double relative = normal_half_widths[level] * deviation;
    const double factor = std::sqrt(1 + relative + relative * relative / 2);
    rmse_[level] = {error.rmse / factor, error.rmse * factor};
  }
}

}  // namespace parray
