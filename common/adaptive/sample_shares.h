#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "common/rooms.h"

namespace parray::adaptive {

/// Distributes samples over pixels in proportion to weights. A pixel never loses samples, so it may
/// keep more than its share. The level L is the number of samples per unit of weight: at level L, a
/// pixel of weight w that now has n samples has max(n, L w) samples. The object is a view of counts
/// and weights. Its sums have the same bits for any number of threads.
class SampleShares {
 public:
  /// Takes one count and one weight per pixel. Weights are finite and not negative.
  SampleShares(std::span<const std::uint32_t> counts, std::span<const float> weights)
      : counts_(counts), weights_(weights) {}

  /// Returns the counts after all pixels together have `total` samples. If `total` and the present
  /// counts are even, so are the new counts, and their sum is exactly `total` unless
  /// limits::max_samples_per_pixel prevents it. Otherwise the sum may differ from `total` by 1,
  /// because it is rounded to whole pairs of samples. If all weights are 0, no pixel gets samples.
  [[nodiscard]] std::vector<std::uint32_t> counts_of(double total) const;
  /// Returns the samples, over all pixels, at a level.
  [[nodiscard]] double total_at(double level) const;
  /// Returns the level at which the pixels have `total` samples.
  [[nodiscard]] double level_for(double total) const;

  [[nodiscard]] std::size_t size() const { return counts_.size(); }  ///< pixels
  [[nodiscard]] double count(std::size_t i) const { return counts_[i]; }
  /// Returns the samples of pixel `i` at a level; at level 0 its present samples.
  [[nodiscard]] double count_at(std::size_t i, double level) const {
    const double share = level * double{weights_[i]};
    return share > counts_[i] ? share : counts_[i];
  }

 private:
  std::span<const std::uint32_t> counts_;
  std::span<const float> weights_;
};

}  // namespace parray::adaptive
