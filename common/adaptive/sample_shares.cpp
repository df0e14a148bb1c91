#include "common/adaptive/sample_shares.h"

#include <algorithm>
#include <cmath>

#include "common/scene/limits.h"

namespace parray {

SampleShares::SampleShares(std::vector<std::uint32_t> counts, std::vector<double> weights)
    : counts_(std::move(counts)), weights_(std::move(weights)) {}

double SampleShares::total_at(double level) const {
  double total = 0;
  for (std::size_t i = 0; i < counts_.size(); ++i) {
    total += count_at(i, level);
  }
  return total;
}

double SampleShares::level_for(double total) const {
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

std::vector<std::uint32_t> SampleShares::counts_of(double total) const {
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

}  // namespace parray
