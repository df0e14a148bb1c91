#include "common/adaptive/error_estimate.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <span>

#include "common/adaptive/noise_model.h"
#include "common/adaptive/pixel_noise.h"

namespace parray::adaptive {
namespace {

/// With 95 % confidence, at most 3 bright samples are expected among as many samples.
/// `mean_inverse`: mean over the pixels of one divided by the pixel's samples.
double unseen_of(double largest, double samples, double mean_inverse) {
  return largest * largest * 3 / samples * mean_inverse;
}

bool has_two(std::uint32_t samples) { return samples >= 2; }

bool all_have_two(const FramebufferView& state) {
  return !state.counts.empty() && std::ranges::all_of(state.counts, has_two);
}

/// Sums that give the mean square error of a picture. Let u and w be the errors of a pixel's two
/// replicates. The pixel's error is e = (u + w) / 2, and half their difference is d = (u - w) / 2.
/// So e^2 - d^2 = uw. For every distribution of samples, uw has mean 0 and variance (2 s^2)^2,
/// where s^2 is the variance of e.
class MeanSquare {
 public:
  void add(const NoiseRow& row) {
    for (std::size_t i = 0; i < row.count.size(); i += 3) {
      const double count = row.count[i];
      if (count < 2) continue;  // only in estimate_rmse_so_far()
      double square = 0;
      double variance = 0;
      for (std::size_t value = i; value < i + 3; ++value) {
        square += row.difference[value] * row.difference[value];
        variance += row.variance[value];
      }
      // Treats the errors of the three channels as equal, which is nearly true.
      scatter_ += 4 * square * variance / count;
      squares_ += square;
      variances_ += variance / count;
      inverse_counts_ += 1.0 / count;
      samples_ += count;
      values_ += 3;
    }
  }

  MeanSquare& operator+=(const MeanSquare& other) {
    squares_ += other.squares_;
    variances_ += other.variances_;
    scatter_ += other.scatter_;
    inverse_counts_ += other.inverse_counts_;
    samples_ += other.samples_;
    values_ += other.values_;
    return *this;
  }

  /// Returns the number of values (R, G, B) that were added.
  [[nodiscard]] double values() const { return values_; }

  void report(double largest, ErrorFigures& error) const {
    // The sampler's gain converts s^2 of independent samples into s^2 of the picture's samples.
    const double gain = variances_ > 0 ? squares_ / variances_ : 0;
    const double relative = squares_ > 0 ? normal_95 * std::sqrt(scatter_ * gain) / squares_ : 0;
    const double factor = 1 + relative + relative * relative / 2;  // about e^relative
    const double square = squares_ / values_;
    const double unseen = unseen_of(largest, samples_, inverse_counts_ * 3 / values_);
    error.rmse = std::sqrt(square);
    error.low = std::sqrt(square / factor);
    error.high = std::sqrt(square * factor + unseen);
  }

 private:
  double squares_ = 0;
  double variances_ = 0;
  double scatter_ = 0;
  double inverse_counts_ = 0;
  double samples_ = 0;
  double values_ = 0;
};

MeanSquare sum_of(const std::vector<MeanSquare>& bands) {
  MeanSquare sum;
  for (const MeanSquare& band : bands) sum += band;
  return sum;
}

MeanSquare mean_square_of(const FramebufferView& state, std::size_t stride) {
  std::vector<MeanSquare> bands(noise_bands(state.height));
  for_noise_bands(state.height, noise_threads(stride), [&](const NoiseBand& band) {
    NoiseRows rows(state, NeighbourhoodSize::neighbours);
    for (std::size_t y = band.first(stride); y < band.end; y += stride) {
      bands[band.number].add(rows.own(y));
    }
  });
  return sum_of(bands);
}

/// Returns two quantiles of `values`, which must not be empty or contain negative numbers.
std::array<float, 2> quantiles(std::span<const float> values, std::array<double, 2> shares) {
  // The bit patterns of such numbers have the order of the numbers. A bin spans 1/32 octave.
  const auto bin_of = [](float value) { return std::bit_cast<std::uint32_t>(value) >> 18; };
  std::vector<std::uint32_t> bins(std::size_t{1} << 14);
  for (const float value : values) ++bins[bin_of(value)];
  std::array<std::size_t, 2> rank{};
  std::array<std::uint32_t, 2> bin{};
  for (std::size_t k = 0; k < 2; ++k) {
    rank[k] = static_cast<std::size_t>(shares[k] * static_cast<double>(values.size() - 1));
    while (rank[k] >= bins[bin[k]]) rank[k] -= bins[bin[k]++];
  }
  std::array<std::vector<float>, 2> alike;
  for (const float value : values) {
    for (std::size_t k = 0; k < 2; ++k) {
      if (bin_of(value) == bin[k]) alike[k].push_back(value);
    }
  }
  std::array<float, 2> found{};
  for (std::size_t k = 0; k < 2; ++k) {
    const auto at = alike[k].begin() + static_cast<std::ptrdiff_t>(rank[k]);
    std::nth_element(alike[k].begin(), at, alike[k].end());
    found[k] = *at;
  }
  return found;
}

}  // namespace

double unseen_square(double largest, std::span<const std::uint32_t> counts) {
  double samples = 0;
  double inverse = 0;
  for (const std::uint32_t count : counts) {
    samples += count;
    inverse += 1.0 / count;
  }
  return unseen_of(largest, samples, inverse / static_cast<double>(counts.size()));
}

ErrorEstimate estimate_rmse(const FramebufferView& state, std::size_t stride) {
  ErrorEstimate error;
  if (all_have_two(state)) mean_square_of(state, stride).report(state.largest_radiance, error);
  return error;
}

PartialError estimate_rmse_so_far(const FramebufferView& state, std::size_t stride) {
  PartialError part;
  if (state.counts.empty()) return part;
  const MeanSquare sum = mean_square_of(state, stride);
  if (sum.values() == 0) return part;
  const auto rendered = std::ranges::count_if(state.counts, has_two);
  part.share = static_cast<double>(rendered) / static_cast<double>(state.counts.size());
  sum.report(state.largest_radiance, part.error);
  return part;
}

ErrorEstimate estimate_error(const FramebufferView& state, std::size_t stride) {
  ErrorEstimate error;
  if (!all_have_two(state)) return error;
  constexpr NeighbourhoodSize horizon = NeighbourhoodSize::neighbours;
  const NoiseModel model = stride > 1 ? NoiseModel(state, horizon, state.pixels.size() / stride)
                                      : NoiseModel(state, horizon);
  const std::size_t bands = noise_bands(state.height);
  std::vector<NoiseForecast> forecasts(bands, NoiseForecast(state.width));
  std::vector<MeanSquare> mean_squares(bands);
  const std::size_t values = std::size_t{3} * state.width;
  error.half_width.resize((state.height + stride - 1) / stride * values);
  visit_noise(state, stride, horizon, [&](std::size_t band, std::size_t y, const NoiseNearby& row) {
    NoiseForecast& forecast = forecasts[band];
    mean_squares[band].add(row.own);
    model.predict(row, forecast);
    half_widths(row.own.count, forecast,
                std::span(error.half_width).subspan(y / stride * values, values));
  });
  sum_of(mean_squares).report(state.largest_radiance, error);
  const auto [middle, high] = quantiles(error.half_width, {0.5, 0.99});
  error.half_width_p50 = middle;
  error.half_width_p99 = high;
  return error;
}

}  // namespace parray::adaptive
