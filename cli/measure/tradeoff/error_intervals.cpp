#include "cli/measure/tradeoff/error_intervals.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "common/adaptive/pixel_noise.h"

namespace parray::tradeoff {
namespace {

/// Half differences of replicates, and sums for the variance of the mean square.
struct Differences {
  std::vector<double> value;   ///< 3 per pixel, row by row
  double squares = 0;          ///< sum of squares
  double variances = 0;        ///< sum of the variances of means
  double by_own_variance = 0;  ///< sum over pixels of square times variance, channels added up
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

/// Means over all pairs of adjacent pixels, horizontally and vertically. Their noise is
/// independent; only the covariance of channels is similar.
struct Neighbours {
  double products = 0;    ///< squared scalar product of their differences
  double magnitudes = 0;  ///< product of the squared lengths of their differences
};

Neighbours neighbours_of(const std::vector<double>& difference, std::size_t width,
                         std::size_t height) {
  Neighbours sum;
  double pairs = 0;
  const auto product_of = [&](std::size_t pixel, std::size_t other) {
    double product = 0;
    for (std::size_t c = 0; c < 3; ++c) {
      product += difference[3 * pixel + c] * difference[3 * other + c];
    }
    return product;
  };
  const auto add = [&](std::size_t pixel, std::size_t other) {
    const double product = product_of(pixel, other);
    sum.products += product * product;
    sum.magnitudes += product_of(pixel, pixel) * product_of(other, other);
    pairs += 1;
  };
  for (std::size_t y = 0; y < height; ++y) {
    for (std::size_t x = 0; x < width; ++x) {
      const std::size_t pixel = y * width + x;
      if (x + 1 < width) add(pixel, pixel + 1);
      if (y + 1 < height) add(pixel, pixel + width);
    }
  }
  if (pairs == 0) return sum;
  return {sum.products / pairs, sum.magnitudes / pairs};
}

/// Returns the variance of the mean square error, divided by its square.
double relative_variance(const Differences& all, std::size_t width, std::size_t height) {
  if (!(all.squares > 0)) return 0;
  const Neighbours near = neighbours_of(all.value, width, height);
  const double alike = near.magnitudes > 0 ? near.products / near.magnitudes : 1;
  const double high = all.by_own_variance * all.squares / all.variances * alike;
  const double low = near.products * static_cast<double>(width * height);
  return 4 * std::sqrt(low * high) / (all.squares * all.squares);
}

}  // namespace

ErrorIntervals::ErrorIntervals(const FramebufferView& state, const ErrorEstimate& error) {
  const Differences all = differences_of(state);
  std::vector<double> ratios;
  for (std::size_t i = 0; i < all.value.size(); ++i) {
    if (all.value[i] != 0) ratios.push_back(std::abs(all.value[i]) / error.half_width[i]);
  }
  const double deviation = std::sqrt(relative_variance(all, state.width, state.height));
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
    // Approximately e^relative, as in the stated interval.
    const double relative = normal_half_widths[level] * deviation;
    const double factor = std::sqrt(1 + relative + relative * relative / 2);
    rmse_[level] = {error.rmse / factor, error.rmse * factor};
  }
}

}  // namespace parray::tradeoff
