#include "common/adaptive/pixel_noise.h"

#include <algorithm>
#include <cmath>

namespace parray {
namespace {

/// As many samples of the largest radiance, seen close by, weigh as much as what is seen around.
constexpr double few = 8;

std::size_t before(std::size_t i, std::size_t size) {
  return i > 0 ? i - 1 : std::min<std::size_t>(1, size - 1);
}

std::size_t after(std::size_t i, std::size_t size) {
  return i + 1 < size ? i + 1 : i - std::min<std::size_t>(1, i);
}

/// A variance, in units of the largest radiance squared, for which `samples` speak, as if bright
/// ones came like rain: that of the gamma distribution's mean, with `wide` before they are seen.
double mixed_with(double wide, double variance, double samples) {
  return wide > 0 ? (few + samples * variance) / (few / wide + samples) : variance;
}

}  // namespace

PixelNoise noise_of(const PixelSums& pixel, std::uint32_t count, const RadianceScale& scale) {
  PixelNoise noise;
  if (count < 2) {
    return noise;
  }
  const std::uint32_t odds = count / 2;
  const std::uint32_t evens = count - odds;
  const double unit = scale.mean(1, 1);
  const double per_sample = 1.0 / count;
  const double unbiased = count / (count - 1.0);
  const double weight = unit / (count * std::sqrt(static_cast<double>(evens) * odds));
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

NoiseWindow::Values NoiseWindow::around(std::size_t x, const Values& own) {
  const std::size_t width = columns_.size();
  const auto add_column = [&](std::size_t at, double sign) {
    for (std::size_t k = 0; k < sum_.size(); ++k) {
      sum_[k] += sign * columns_[at][k];
    }
  };
  for (; next_ < std::min(x + reach_ + 1, width); ++next_) {
    add_column(next_, 1);
  }
  if (x > reach_) {
    add_column(x - reach_ - 1, -1);
  }
  const std::size_t columns = next_ - (x - std::min(x, reach_));
  const auto others = static_cast<double>(std::max<std::size_t>(columns * (end_ - first_), 2) - 1);
  Values mean;
  for (std::size_t k = 0; k < mean.size(); ++k) {
    mean[k] = (sum_[k] - own[k]) / others;
  }
  return mean;
}

void NoiseWindow::add(std::span<const Values> row, double sign) {
  for (std::size_t x = 0; x < columns_.size(); ++x) {
    for (std::size_t k = 0; k < sum_.size(); ++k) {
      columns_[x][k] += sign * row[x][k];
    }
  }
}

NoiseRows::NoiseRows(const FramebufferView& state, NeighbourhoodSize horizon)
    : state_(state),
      horizon_(horizon),
      scale_(state.largest_radiance),
      unit_(state.largest_radiance * state.largest_radiance),
      noise_(rows_kept, std::vector<PixelNoise>(state.width)),
      values_(rows_kept, std::vector<NoiseWindow::Values>(state.width)),
      near_(near, state.width),
      far_(far, state.width),
      row_(state.width) {}

std::span<const NoiseNearby> NoiseRows::row(std::size_t y) {
  const auto values_at = [&](std::size_t at) -> std::span<const NoiseWindow::Values> {
    keep_rows_until(at + 1);
    return values_[at % rows_kept];
  };
  const std::size_t reach = horizon_ == NeighbourhoodSize::windows ? far : 1;
  have_ = std::max(have_, y - std::min(y, reach));
  if (horizon_ == NeighbourhoodSize::windows) {
    far_.move_to(y, state_.height, values_at);
    near_.move_to(y, state_.height, values_at);
  } else {
    keep_rows_until(std::min<std::size_t>(y + 2, state_.height));
  }
  for (std::size_t x = 0; x < state_.width; ++x) {
    look_around(x, y);
    if (horizon_ == NeighbourhoodSize::windows) {
      look_afar(x, values_at(y)[x]);
    }
  }
  return row_;
}

void NoiseRows::look_afar(std::size_t x, const NoiseWindow::Values& own) {
  const NoiseWindow::Values close_by = near_.around(x, own);
  const NoiseWindow::Values far_off = far_.around(x, own);
  const double samples = far_off[3];
  for (std::size_t channel = 0; channel < 3; ++channel) {
    NeighbourhoodNoise& around = row_[x].around[channel];
    const double wide = mixed_with(far_off[channel], close_by[channel], 80 * samples);
    const double mixed = mixed_with(wide, around.mean / unit_, 8 * samples);
    around.seen = 8 * samples * mixed;
    around.mean = unit_ * mixed;
  }
}

void NoiseRows::keep_rows_until(std::size_t y) {
  for (; have_ < y; ++have_) {
    std::vector<PixelNoise>& noise = noise_[have_ % rows_kept];
    std::vector<NoiseWindow::Values>& values = values_[have_ % rows_kept];
    for (std::size_t x = 0; x < state_.width; ++x) {
      const std::size_t i = have_ * state_.width + x;
      noise[x] = noise_of(state_.pixels[i], state_.counts[i], scale_);
      for (std::size_t channel = 0; channel < 3; ++channel) {
        values[x][channel] = NoiseWindow::rounded(noise[x].variance[channel] / unit_);
      }
      values[x][3] = state_.counts[i];
    }
  }
}

const std::vector<PixelNoise>& NoiseRows::noise_at(std::size_t y) const {
  return noise_[y % rows_kept];
}

void NoiseRows::look_around(std::size_t x, std::size_t y) {
  const std::size_t up = before(y, state_.height);
  const std::size_t down = after(y, state_.height);
  const std::size_t left = before(x, state_.width);
  const std::size_t right = after(x, state_.width);
  using Place = std::array<std::size_t, 2>;  // row and column
  const std::array<std::array<Place, 2>, 4> opposite{{{{{up, left}, {down, right}}},
                                                      {{{up, x}, {down, x}}},
                                                      {{{up, right}, {down, left}}},
                                                      {{{y, left}, {y, right}}}}};
  NoiseNearby& nearby = row_[x];
  nearby = {noise_at(y)[x], {}};
  for (const auto& [here, there] : opposite) {
    const PixelNoise& a = noise_at(here[0])[here[1]];
    const PixelNoise& b = noise_at(there[0])[there[1]];
    for (std::size_t channel = 0; channel < 3; ++channel) {
      NeighbourhoodNoise& around = nearby.around[channel];
      around.radiance += (a.mean[channel] + b.mean[channel]) / 8;
      around.mean += (a.variance[channel] + b.variance[channel]) / 8;
      around.ridge = std::max(around.ridge, std::min(a.variance[channel], b.variance[channel]));
    }
  }
}

}  // namespace parray
