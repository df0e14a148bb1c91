#include "common/adaptive/allocation.h"

#include <algorithm>
#include <cmath>

#include "common/adaptive/noise_model.h"
#include "common/adaptive/pixel_noise.h"
#include "common/scene/limits.h"

namespace parray {
namespace {

/// Bias that a pixel's own luck may bring, of its mean. If the pixel's count follows its own
/// variance to a share s, the bias is up to s * third moment / (variance * count) <= s * largest /
/// count.
constexpr double bias_allowed = 0.001;

/// Mean square error expected of a pixel, times its count. What the model has learnt of pixels with
/// such surroundings knows of their luck, too: it counts for as much as has been seen there.
double expected_square(const NoiseModel& model, const NeighbourhoodNoise& around) {
  constexpr double much = 8;
  const double learnt = model.expected_square(around);
  const double share = around.seen / (around.seen + much);
  const double trust = around.mean > 0 ? share * share : 1;
  return trust * learnt + (1 - trust) * around.mean;
}

}  // namespace

Allocation::Allocation(const FramebufferView& state, bool equal_half_widths)
    : counts_(state.counts.begin(), state.counts.end()),
      weights_(state.pixels.size()),
      squares_(state.pixels.size()) {
  const NoiseModel model(state, NeighbourhoodSize::windows);
  visit_noise(state, 1, NeighbourhoodSize::windows, [&](std::size_t i, const NoiseNearby& noise) {
    double most = 0;
    double sum = 0;
    for (std::size_t channel = 0; channel < 3; ++channel) {
      const NeighbourhoodNoise& around = noise.around[channel];
      const double radiance = std::min(noise.own.mean[channel], around.radiance);
      const double share =
          std::min(1.0, bias_allowed * radiance * counts_[i] / state.largest_radiance);
      const double own = model.own_square(noise.own.variance[channel]);
      const double square = (1 - share) * expected_square(model, around) + share * own;
      most = std::max(most, model.half_width_square(square, around));
      sum += square;
      squares_[i] += own;
    }
    weights_[i] = equal_half_widths ? most : std::sqrt(sum);
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
    if (wanted <= counts_[i]) {
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
