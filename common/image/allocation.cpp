#include "common/image/allocation.h"

#include <algorithm>
#include <cmath>

#include "common/image/noise_model.h"
#include "common/image/pixel_noise.h"
#include "common/scene/limits.h"

namespace parray {

Allocation::Allocation(const PictureState& state, bool equal_half_widths)
    : counts_(state.counts.begin(), state.counts.end()), weights_(state.pixels.size()) {
  NoiseModel model(state.largest_radiance);
  visit_noise(state, [&](std::size_t i, const NoiseNearby& noise) {
    for (std::size_t channel = 0; channel < 3; ++channel) {
      model.add(noise.own.variance[channel], noise.around[channel], noise.own.difference[channel],
                counts_[i]);
    }
  });
  model.calibrate();
  visit_noise(state, [&](std::size_t i, const NoiseNearby& noise) {
    double most = 0;
    double sum = 0;
    for (const Surroundings& around : noise.around) {
      most = std::max(most, model.expected_half_width_square(around));
      sum += model.expected_square(around);
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

double Allocation::square_error_at(double level) const {
  double square = 0;
  for (std::size_t i = 0; i < counts_.size(); ++i) {
    square += weights_[i] * weights_[i] / std::max<double>(counts_[i], level * weights_[i]);
  }
  return square;
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
  for (std::size_t i = 0; i < counts.size(); ++i) {
    const double wanted = level * weights_[i];
    if (wanted <= counts_[i]) {
      continue;
    }
    const double exactly = std::min<double>(wanted + owed, limits::max_samples_per_pixel);
    const auto even = static_cast<std::uint32_t>(std::max(exactly, 0.0)) / 2 * 2;
    counts[i] = std::max(counts_[i], even);
    owed = exactly - counts[i];
  }
  return counts;
}

double Allocation::total_for_square_error(double share) const {
  const double wanted = share * square_error_at(0);
  double little = 0;
  double enough = level_for(total_at(0) * 2);
  while (square_error_at(enough) > wanted) {
    little = enough;
    enough *= 2;
  }
  for (int step = 0; step < 8; ++step) {
    const double middle = (little + enough) / 2;
    (square_error_at(middle) > wanted ? little : enough) = middle;
  }
  return total_at(enough);
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
