#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "common/rooms.h"

namespace parray::adaptive {

/// Samples of pixels that are to be in proportion to weights, where a pixel may already have more
/// than its share: samples are not taken away. At a level L a pixel of weight w has at least L w.
/// A view. Sums are the same for any number of threads.
class SampleShares {
 public:
  /// As many counts as weights, which are finite and not negative.
  SampleShares(std::span<const std::uint32_t> counts, std::span<const float> weights)
      : counts_(counts), weights_(weights) {}

  /// Counts of `total` samples, all pixels together. What a pixel gets is even; so is `total`, and
  /// it is met exactly unless limits::max_samples_per_pixel is in the way.
  [[nodiscard]] std::vector<std::uint32_t> counts_of(double total) const;
  /// Samples, all pixels together, at a level.
  [[nodiscard]] double total_at(double level) const;
  /// The level at which the pixels have `total` samples.
  [[nodiscard]] double level_for(double total) const;

  [[nodiscard]] std::size_t size() const { return counts_.size(); }
  [[nodiscard]] double count(std::size_t i) const { return counts_[i]; }
  [[nodiscard]] double count_at(std::size_t i, double level) const {
    const double share = level * double{weights_[i]};
    return share > counts_[i] ? share : counts_[i];
  }
  [[nodiscard]] double weight(std::size_t i) const { return weights_[i]; }

 private:
  std::span<const std::uint32_t> counts_;
  std::span<const float> weights_;
};

}  // namespace parray::adaptive
