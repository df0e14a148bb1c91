#include "common/adaptive/error_estimate.h"

#include <algorithm>
#include <cmath>

#include "common/adaptive/noise_model.h"
#include "common/adaptive/pixel_noise.h"

namespace parray {
namespace {

constexpr double normal_95 = 1.959964;  ///< half the width of a normal's 95 % interval

bool all_have_two(const FramebufferView& state) {
  return !state.counts.empty() &&
         std::all_of(state.counts.begin(), state.counts.end(), [](auto n) { return n >= 2; });
}

/// Mean square error of a picture. With u and w the errors of a pixel's two replicates, its error
/// e = (u + w) / 2 and its difference d = (u - w) / 2 fulfil e^2 - d^2 = uw: whatever the
/// distribution of samples, that has mean 0, and variance (2 s^2)^2 where s^2 is that of e.
class MeanSquare {
 public:
  void add(const PixelNoise& noise, std::uint32_t count) {
    double square = 0;
    double variance = 0;
    for (std::size_t channel = 0; channel < 3; ++channel) {
      square += noise.difference[channel] * noise.difference[channel];
      variance += noise.variance[channel];
    }
    // As if the channels' errors were alike, which they nearly are.
    scatter_ += 4 * square * variance / count;
    squares_ += square;
    variances_ += variance / count;
    seldom_ += 1.0 / count;
    samples_ += count;
    values_ += 3;
  }

  void report(double largest, ErrorEstimate& error) const {
    // The sampler's gain turns s^2 for independent samples into that of these.
    const double gain = variances_ > 0 ? squares_ / variances_ : 0;
    const double relative = squares_ > 0 ? normal_95 * std::sqrt(scatter_ * gain) / squares_ : 0;
    const double factor = 1 + relative + relative * relative / 2;  // e^relative, nearly
    const double square = squares_ / values_;
    // What no sample has shown may still be there: 3 in all samples, 95 times of 100.
    const double unseen = largest * largest * 3 / samples_ * (seldom_ * 3 / values_);
    error.rmse = std::sqrt(square);
    error.low = std::sqrt(square / factor);
    error.high = std::sqrt(square * factor + unseen);
  }

 private:
  double squares_ = 0;
  double variances_ = 0;
  double scatter_ = 0;
  double seldom_ = 0;
  double samples_ = 0;
  double values_ = 0;
};

/// The values at two shares of the way up; reorders them.
std::pair<float, float> quantiles(std::vector<float>& values, double low, double high) {
  const auto at = [&](double share) {
    return values.begin() +
           static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
  };
  std::nth_element(values.begin(), at(high), values.end());
  std::nth_element(values.begin(), at(low), at(high));
  return {*at(low), *at(high)};
}

}  // namespace

ErrorEstimate estimate_rmse(const FramebufferView& state) {
  ErrorEstimate error;
  if (!all_have_two(state)) {
    return error;
  }
  const RadianceScale scale(state.largest_radiance);
  MeanSquare mean_square;
  for (std::size_t i = 0; i < state.pixels.size(); ++i) {
    mean_square.add(noise_of(state.pixels[i], state.counts[i], scale), state.counts[i]);
  }
  mean_square.report(state.largest_radiance, error);
  return error;
}

ErrorEstimate estimate_error(const FramebufferView& state) {
  ErrorEstimate error = estimate_rmse(state);
  if (error.rmse < 0) {
    return error;
  }
  const NoiseModel model(state, NeighbourhoodSize::neighbours);
  error.half_width.resize(state.pixels.size() * 3);
  visit_noise(state, 1, NeighbourhoodSize::neighbours,
              [&](std::size_t i, const NoiseNearby& noise) {
                for (std::size_t channel = 0; channel < 3; ++channel) {
                  error.half_width[i * 3 + channel] = static_cast<float>(model.half_width(
                      noise.own.variance[channel], noise.around[channel], state.counts[i]));
                }
              });
  std::vector<float> sorted = error.half_width;
  const auto [middle, high] = quantiles(sorted, 0.5, 0.99);
  error.half_width_p50 = middle;
  error.half_width_p99 = high;
  return error;
}

}  // namespace parray
