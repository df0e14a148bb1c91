#include "common/adaptive/pixel_noise.h"

#include <algorithm>
#include <cmath>

#include "common/base/bands.h"
#include "common/math/float_mode.h"

namespace parray::adaptive {
namespace {

/// This many samples of the largest radiance in the neighbours weigh as much as the wider window.
constexpr double few = 8;

std::size_t before(std::size_t i, std::size_t size) {
  return i > 0 ? i - 1 : std::min<std::size_t>(1, size - 1);
}

std::size_t after(std::size_t i, std::size_t size) {
  return i + 1 < size ? i + 1 : i - std::min<std::size_t>(1, i);
}

/// Returns a variance, in units of the largest radiance squared, that mixes `variance`, supported
/// by `samples`, with that of a wider window, `wide`. Bright samples are modelled as a Poisson
/// process: the result is the mean of the gamma distribution with `wide` as the prior.
double mixed_with(double wide, double variance, double samples) {
  const double divisor = wide > 0 ? wide : 1;
  const double mixed = (few + samples * variance) / (few / divisor + samples);
  return wide > 0 ? mixed : variance;
}

/// Sums of 2^24 samples fit 63 bits, and signed numbers are converted by one instruction.
double number_of(std::uint64_t sum) { return static_cast<double>(static_cast<std::int64_t>(sum)); }

/// Returns max(value, 0) without a branch, because noise would make the branch unpredictable.
double positive_part(double value) { return (value + std::abs(value)) / 2; }

/// Factors of noise_of() that depend on a pixel's count alone. They are zeros for counts below 2,
/// which makes all noise 0.
struct CountFactors {
  std::uint32_t count = 0;
  /// Factor of a sum; units are powers of two, which can be multiplied in any order.
  double mean = 0;
  double square = 0;  ///< factor of a sum of squares
  double unbiased = 0;
  double odds = 0;
  double evens = 0;
  double weight = 0;

  CountFactors() = default;
  CountFactors(std::uint32_t samples, const RadianceScale& scale) : count(samples) {
    if (count >= 2) {
      const double unit = scale.mean(1, 1);
      mean = 1.0 / count * unit;
      square = 1.0 / count * scale.mean_square(1, 1);
      unbiased = count / (count - 1.0);
      const std::uint32_t half = count / 2;
      odds = half;
      evens = count - odds;
      weight = unit / (count * std::sqrt(evens * odds));
    }
  }

  [[nodiscard]] PixelNoise noise_of(const PixelSums& pixel) const {
    PixelNoise noise;
    for (std::size_t channel = 0; channel < 3; ++channel) {
      const double own_mean = number_of(pixel.sum[channel]) * mean;
      const double own_square = number_of(pixel.sum_of_squares[channel]) * square;
      const double odd = number_of(pixel.odd[channel]);
      const double even = number_of(pixel.sum[channel] - pixel.odd[channel]);
      // Squares are stored rounded down, so the computed variance of equal samples may be negative.
      noise.variance[channel] = positive_part((own_square - own_mean * own_mean) * unbiased);
      noise.mean[channel] = own_mean;
      noise.difference[channel] = (even * odds - odd * evens) * weight;
    }
    return noise;
  }
};

/// Values of three rows around a pixel. `up`, `own` and `down` point to the row's first pixel; one
/// more pixel lies before the first and one behind the last.
struct ThreeRows {
  const double* up;
  const double* own;
  const double* down;
};

/// Computes the means of the 8 neighbours of each of `values`.
void mean_around(const ThreeRows& rows, std::span<double> values) {
  const auto [up, own, down] = rows;
  double* const mean = values.data();
  const auto size = static_cast<std::ptrdiff_t>(values.size());
  for (std::ptrdiff_t i = 0; i < size; ++i) {
    mean[i] = ((up[i - 3] + down[i + 3]) + (up[i] + down[i]) + (up[i + 3] + down[i - 3]) +
               (own[i - 3] + own[i + 3])) /
              8;
  }
}

/// Computes the largest value that both of two opposite neighbours reach.
void ridge_around(const ThreeRows& rows, std::span<double> values) {
  const auto [up, own, down] = rows;
  double* const ridge = values.data();
  const auto size = static_cast<std::ptrdiff_t>(values.size());
  for (std::ptrdiff_t i = 0; i < size; ++i) {
    const double falling = std::min(up[i - 3], down[i + 3]);
    const double upright = std::min(up[i], down[i]);
    const double rising = std::min(up[i + 3], down[i - 3]);
    const double level = std::min(own[i - 3], own[i + 3]);
    ridge[i] = std::max(std::max(falling, upright), std::max(rising, level));
  }
}

/// Returns the values without the mirrored pixels at both ends.
std::span<const double> inner(const std::vector<double>& values) {
  return std::span(values).subspan(3, values.size() - 6);
}

}  // namespace

PixelNoise noise_of(const PixelSums& pixel, std::uint32_t count, const RadianceScale& scale) {
  return CountFactors(count, scale).noise_of(pixel);
}

std::size_t noise_bands(std::size_t height) {
  // A band also reads up to 32 rows beyond it, which the neighbouring bands read as well.
  constexpr std::size_t least_rows = 128;
  constexpr std::size_t most = 16;
  return std::clamp<std::size_t>(height / least_rows, 1, most);
}

void for_noise_bands(std::size_t height, int threads,
                     const std::function<void(const NoiseBand&)>& work) {
  const std::size_t bands = noise_bands(height);
  side_by_side(bands, threads, [&](std::size_t band) {
    const FloatMode ieee;
    work({band, height * band / bands, height * (band + 1) / bands});
  });
}

NoiseWindow::NoiseWindow(std::size_t reach, std::size_t width)
    : reach_(reach), width_(width), columns_(4 * (width + 2 * reach + 1)), others_(3 * width) {}

void NoiseWindow::means(Row own, std::span<double> variances, std::span<double> samples) {
  // At each pixel a column comes in and one goes.
  std::array<double, 4> sum{};
  for (std::size_t i = 0; i < 8 * reach_; ++i) sum[i % 4] += columns_[4 + i];
  for (std::size_t x = 0; x < width_; ++x) {
    const double* const gone = columns_.data() + 4 * x;
    const double* const come = gone + 4 * (2 * reach_ + 1);
    for (std::size_t k = 0; k < 4; ++k) sum[k] += come[k] - gone[k];
    const std::size_t columns = std::min(x + reach_ + 1, width_) - (x - std::min(x, reach_));
    const auto others =
        static_cast<double>(std::max<std::size_t>(columns * (end_ - first_), 2) - 1);
    for (std::size_t channel = 0; channel < 3; ++channel) {
      variances[3 * x + channel] = sum[channel] - own[4 * x + channel];
      samples[3 * x + channel] = sum[3] - own[4 * x + 3];
      others_[3 * x + channel] = others;
    }
  }
  for (std::size_t i = 0; i < others_.size(); ++i) {
    variances[i] /= others_[i];
    samples[i] /= others_[i];
  }
}

void NoiseWindow::add(Row row, double sign) {
  double* const sums = columns_.data() + 4 * (reach_ + 1);
  for (std::size_t i = 0; i < row.size(); ++i) sums[i] += sign * row[i];
}

NoiseRows::NoiseRows(const FramebufferView& state, NeighbourhoodSize horizon)
    : state_(state),
      windows_(horizon == NeighbourhoodSize::windows),
      reach_(windows_ ? far : 1),
      scale_(state.largest_radiance),
      unit_(state.largest_radiance * state.largest_radiance),
      kept_(2 * reach_ + 2),
      near_(near, windows_ ? state.width : 0),
      far_(far, windows_ ? state.width : 0),
      mean_(std::size_t{3} * state.width),
      ridge_(std::size_t{3} * state.width) {
  const Values with_ends(3 * (std::size_t{state.width} + 2));
  for (Kept& row : kept_) {
    row = {with_ends, with_ends, with_ends, with_ends, Values(windows_ ? 4 * state.width : 0)};
  }
  if (windows_) close_by_ = far_off_ = samples_ = radiance_ = seen_ = mean_;
}

NoiseNearby NoiseRows::row(std::size_t y) {
  have_ = std::max(have_, y - std::min(y, reach_));
  if (windows_) {
    const auto rounded_at = [&](std::size_t at) -> NoiseWindow::Row {
      keep_rows_until(at + 1);
      return kept(at).rounded;
    };
    far_.move_to(y, state_.height, rounded_at);
    near_.move_to(y, state_.height, rounded_at);
  } else {
    keep_rows_until(std::min<std::size_t>(y + 2, state_.height));
  }
  look_around(y);
  if (windows_) look_afar(y);
  return {own(y), {mean_, ridge_, radiance_, seen_}};
}

NoiseRow NoiseRows::own(std::size_t y) {
  have_ = std::max(have_, y);
  keep_rows_until(y + 1);
  const Kept& row = kept(y);
  return {inner(row.count), inner(row.mean), inner(row.variance), inner(row.difference)};
}

void NoiseRows::keep_rows_until(std::size_t y) {
  for (; have_ < y; ++have_) keep(have_);
}

void NoiseRows::keep(std::size_t y) {
  constexpr std::size_t ahead = 32;  // pixels: 2 KiB, which no processor fetches by itself
  Kept& row = kept(y);
  CountFactors factors;
  for (std::size_t x = 0; x < state_.width; ++x) {
    const std::size_t i = y * state_.width + x;
    if (state_.counts[i] != factors.count) factors = CountFactors(state_.counts[i], scale_);
    __builtin_prefetch(state_.pixels.data() + i + ahead);
    const PixelNoise noise = factors.noise_of(state_.pixels[i]);
    for (std::size_t channel = 0; channel < 3; ++channel) {
      const std::size_t at = 3 * (x + 1) + channel;
      row.count[at] = factors.count;
      row.mean[at] = noise.mean[channel];
      row.variance[at] = noise.variance[channel];
      row.difference[at] = noise.difference[channel];
    }
  }
  const auto mirror = [&](Values& values) {
    const auto pixel = [&](std::size_t x) {
      return values.begin() + 3 * static_cast<std::ptrdiff_t>(x + 1);
    };
    std::copy_n(pixel(before(0, state_.width)), 3, values.begin());
    std::copy_n(pixel(after(state_.width - 1, state_.width)), 3, values.end() - 3);
  };
  mirror(row.mean);
  mirror(row.variance);
  for (std::size_t x = 0; 4 * x < row.rounded.size(); ++x) {
    for (std::size_t channel = 0; channel < 3; ++channel) {
      row.rounded[4 * x + channel] =
          NoiseWindow::rounded(row.variance[3 * (x + 1) + channel] / unit_);
    }
    row.rounded[4 * x + 3] = row.count[3 * (x + 1)];
  }
}

void NoiseRows::look_around(std::size_t y) {
  const Kept& up = kept(before(y, state_.height));
  const Kept& own = kept(y);
  const Kept& down = kept(after(y, state_.height));
  const auto around = [&](const Values Kept::*values) {
    return ThreeRows{(up.*values).data() + 3, (own.*values).data() + 3, (down.*values).data() + 3};
  };
  mean_around(around(&Kept::variance), mean_);
  ridge_around(around(&Kept::variance), ridge_);
  if (windows_) mean_around(around(&Kept::mean), radiance_);
}

void NoiseRows::look_afar(std::size_t y) {
  near_.means(kept(y).rounded, close_by_, samples_);
  far_.means(kept(y).rounded, far_off_, samples_);
  const double unit = unit_;
  for (std::size_t i = 0; i < mean_.size(); ++i) {
    const double samples = samples_[i];
    const double wide = mixed_with(far_off_[i], close_by_[i], 80 * samples);
    const double mixed = mixed_with(wide, mean_[i] / unit, 8 * samples);
    seen_[i] = 8 * samples * mixed;
    mean_[i] = unit * mixed;
  }
}

}  // namespace parray::adaptive
