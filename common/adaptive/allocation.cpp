#include "common/adaptive/allocation.h"

#include <algorithm>
#include <cmath>
#include <span>
#include <vector>

#include "common/adaptive/noise_model.h"
#include "common/adaptive/pixel_noise.h"
#include "common/scene/limits.h"

namespace parray {
namespace {

/// Bias that a pixel's own luck may bring, of its mean. If the pixel's count follows its own
/// variance to a share s, the bias is up to s * third moment / (variance * count) <= s * largest /
/// count.
constexpr double bias_allowed = 0.001;

/// Mean square errors expected of a row's values, times their counts.
void expect(const NoiseNearby& row, const NoiseForecast& forecast, double largest_radiance,
            std::span<double> squares) {
  // What the model has learnt of pixels with such surroundings knows of their luck, too: it counts
  // for as much as has been seen there.
  constexpr double much = 8;
  for (std::size_t i = 0; i < squares.size(); ++i) {
    const double mean = row.around.mean[i];
    const double seen = row.around.seen[i] / (row.around.seen[i] + much);
    const double trust = mean > 0 ? seen * seen : 1;
    const double expected = trust * forecast.expected[i] + (1 - trust) * mean;
    const double own_radiance = row.own.mean[i];
    const double radiance_around = row.around.radiance[i];
    const double radiance = std::min(own_radiance, radiance_around);
    const double share =
        std::min(1.0, bias_allowed * radiance * row.own.count[i] / largest_radiance);
    squares[i] = (1 - share) * expected + share * forecast.own[i];
  }
}

}  // namespace

Allocation::Allocation(const FramebufferView& state, bool equal_half_widths)
    : counts_(state.counts.begin(), state.counts.end()),
      weights_(state.pixels.size()),
      squares_(state.pixels.size()) {
  constexpr NeighbourhoodSize horizon = NeighbourhoodSize::windows;
  const NoiseModel model(state, horizon);
  NoiseForecast forecast(state.width);
  std::vector<double> squares(std::size_t{3} * state.width);
  visit_noise(state, 1, horizon, [&](std::size_t y, const NoiseNearby& row) {
    model.foresee(row, forecast);
    expect(row, forecast, state.largest_radiance, squares);
    for (std::size_t x = 0; x < state.width; ++x) {
      const std::size_t i = y * state.width + x;
      double most = 0;
      double sum = 0;
      for (std::size_t value = 3 * x; value < 3 * x + 3; ++value) {
        most = std::max(most, half_width_square(squares[value], forecast.half_width[value]));
        sum += squares[value];
        squares_[i] += forecast.own[value];
      }
      weights_[i] = equal_half_widths ? most : std::sqrt(sum);
    }
  });
}

double Allocation::total_at(double level) const {
  double total = 0;
  for (std::size_t i = 0; i < counts_.size(); ++i) {
    total += std::max<double>(counts_[i], level * weights_[i]);
  }
  return total;
}

double Allocation::level_for(double total) const {
  // Pixels that have more than their share already drop out, until the rest shares what is left.
  double level = 0;
  for (double fixed = -1;;) {
    double have = 0;
    double weight = 0;
    double out = 0;
    for (std::size_t i = 0; i < counts_.size(); ++i) {
      if (fixed >= 0 && counts_[i] >= level * weights_[i]) {
        have += counts_[i];
        out += 1;
      } else {
        weight += weights_[i];
      }
    }
    if (out == fixed || !(weight > 0)) {
      return level;
    }
    fixed = out;
    level = (total - have) / weight;
  }
}

std::vector<std::uint32_t> Allocation::counts_of(double total) const {
  const double level = level_for(total);
  std::vector<std::uint32_t> counts = counts_;
  double owed = 0;
  std::size_t last = 0;
  for (std::size_t i = 0; i < counts.size(); ++i) {
    const double wanted = level * weights_[i];
    if (!(wanted > counts_[i])) {  // or not a number: nothing shines, nothing is noisy
      continue;
    }
    const double exactly = wanted + owed;
    const double possible = std::clamp<double>(exactly, 0, limits::max_samples_per_pixel);
    counts[i] = std::max(counts_[i], static_cast<std::uint32_t>(possible) / 2 * 2);
    owed = exactly - counts[i];
    last = i;
  }
  // Rounding may have lost the last pair, and a pixel that is full leaves more over.
  for (std::size_t k = 0; k < counts.size() && owed > 1; ++k) {
    std::uint32_t& count = counts[(last + k) % counts.size()];
    const std::uint32_t room = (limits::max_samples_per_pixel - count) / 2 * 2;
    const double given = std::min<double>(room, 2 * std::floor(owed / 2 + 0.5));
    count += static_cast<std::uint32_t>(given);
    owed -= given;
  }
  return counts;
}

double Allocation::square_error_at(double level) const {
  double square = 0;
  for (std::size_t i = 0; i < counts_.size(); ++i) {
    square += squares_[i] / std::max<double>(counts_[i], level * weights_[i]);
  }
  return square;
}

double Allocation::total_for_square_error(double share) const {
  const double wanted = share * square_error_at(0);
  // The error at a level falls about as fast as the level rises.
  double level = level_for(total_at(0) / share);
  for (int step = 0; step < 4; ++step) {
    level *= square_error_at(level) / wanted;
  }
  return total_at(level);
}

double Allocation::share_of_square_error(double total) const {
  const double now = square_error_at(0);
  return now > 0 ? square_error_at(level_for(total)) / now : 1;
}

double Allocation::total_for_square_half_width(double share) const {
  // The pixel whose half-width 99 % of the pixels keep below.
  std::vector<double> levels(counts_.size());
  for (std::size_t i = 0; i < levels.size(); ++i) {
    levels[i] = weights_[i] > 0 ? counts_[i] / weights_[i] : 0;
  }
  const auto worst = levels.begin() + static_cast<std::ptrdiff_t>(levels.size() / 100);
  std::nth_element(levels.begin(), worst, levels.end());
  return total_at(*worst / share);
}

}  // namespace parray
