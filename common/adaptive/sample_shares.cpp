#include "common/adaptive/sample_shares.h"

#include <algorithm>
#include <cmath>

#include "common/adaptive/ordered_sums.h"
#include "common/scene/limits.h"

namespace parray::adaptive {
namespace {

/// Sums over pixels at a level. A pixel is full if it already has its share.
struct Level {
  double have = 0;    ///< samples of the full pixels
  double full = 0;    ///< number of full pixels
  double weight = 0;  ///< sum of the other pixels' weights

  Level& operator+=(const Level& other) {
    have += other.have;
    full += other.full;
    weight += other.weight;
    return *this;
  }
};

}  // namespace

double SampleShares::total_at(double level) const {
  return ordered_sum<double>(size(), [&](std::size_t begin, std::size_t end) {
    double total = 0;
    for (std::size_t i = begin; i < end; ++i) total += count_at(i, level);
    return total;
  });
}

double SampleShares::level_for(double total) const {
  // Each step leaves out the pixels that already have more than their share. The other pixels share
  // the remaining samples. The loop ends when no further pixel drops out.
  double level = 0;
  for (double full = -1;;) {
    const auto sum = ordered_sum<Level>(size(), [&](std::size_t begin, std::size_t end) {
      Level part;
      for (std::size_t i = begin; i < end; ++i) {
        const double count = counts_[i];
        const double weight = weights_[i];
        const bool has = full >= 0 && count >= level * weight;
        part.have += has ? count : 0;
        part.full += has ? 1 : 0;
        part.weight += has ? 0 : weight;
      }
      return part;
    });
    if (sum.full == full || !(sum.weight > 0)) return level;
    full = sum.full;
    level = (total - sum.have) / sum.weight;
  }
}

std::vector<std::uint32_t> SampleShares::counts_of(double total) const {
  const double level = level_for(total);
  std::vector<std::uint32_t> counts(counts_.begin(), counts_.end());
  // The rounding error of a pixel carries over to the next pixel. `owed` is the sum of what the
  // last pixels carry over.
  double owed = ordered_sum<double>(size(), [&](std::size_t begin, std::size_t end) {
    double debt = 0;
    for (std::size_t i = begin; i < end; ++i) {
      const double wanted = level * double{weights_[i]};
      if (!(wanted > counts_[i])) {  // also if `wanted` is NaN, because no pixel is noisy
        continue;
      }
      const double exactly = wanted + debt;
      const double possible = std::clamp<double>(exactly, 0, limits::max_samples_per_pixel);
      counts[i] = std::max(counts_[i], static_cast<std::uint32_t>(possible) / 2 * 2);
      debt = exactly - counts[i];
    }
    return debt;
  });
  // Pixels at the limit of samples leave samples over. The last pixels that got samples take them;
  // if these have no room, any pixels do.
  for (const bool any : {false, true}) {
    for (std::size_t k = counts.size(); k > 0 && owed > 1; --k) {
      std::uint32_t& count = counts[k - 1];
      if (!any && !(level * double{weights_[k - 1]} > counts_[k - 1])) continue;
      const std::uint32_t room = (limits::max_samples_per_pixel - count) / 2 * 2;
      const double given = std::min<double>(room, 2 * std::floor(owed / 2 + 0.5));
      count += static_cast<std::uint32_t>(given);
      owed -= given;
    }
  }
  return counts;
}

}  // namespace parray::adaptive
