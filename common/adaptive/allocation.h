#pragma once

#include <cstdint>
#include <vector>

#include "common/adaptive/passes.h"

namespace parray {

/// Where the samples of a picture serve best, from what the pixels around each have shown. A
/// pixel's own samples have a say only as far as their number makes them: their mean would be
/// biased if their luck decided how many follow.
///
/// For the least mean square error a pixel's count is in proportion to the deviation of its samples
/// (Neyman, "On the two different aspects of the representative method", 1934), for equal
/// half-widths to their variance. Samples that a pixel has are not taken away.
class Allocation {
 public:
  /// Each pixel of `state` has at least 2 samples.
  Allocation(const FramebufferView& state, bool equal_half_widths);

  /// Counts of `total` samples, all pixels together. What a pixel gets is even; so is `total`, and
  /// it is met exactly unless limits::max_samples_per_pixel is in the way.
  [[nodiscard]] std::vector<std::uint32_t> counts_of(double total) const;

  /// Samples, all pixels together, that are expected to bring the mean square error, or the square
  /// of the half-width that 99 % of the pixels have, to `share` of what it is, 0 < share < 1.
  [[nodiscard]] double total_for_square_error(double share) const;
  [[nodiscard]] double total_for_square_half_width(double share) const;
  /// The other way round: what `total` samples, no fewer than there are, leave of the mean square
  /// error; 1 if there is none.
  [[nodiscard]] double share_of_square_error(double total) const;

 private:
  /// Sum of the expected square errors of all pixels and channels if a pixel of weight w has at
  /// least level * w samples.
  [[nodiscard]] double square_error_at(double level) const;
  /// Samples, all pixels together, if a pixel of weight w has at least level * w.
  [[nodiscard]] double total_at(double level) const;
  /// The level at which the pixels have `total` samples.
  [[nodiscard]] double level_for(double total) const;

  std::vector<std::uint32_t> counts_;
  std::vector<double> weights_;
  /// Mean square errors times counts by the pixels' own variances: each says little, their sum is
  /// right, since weights hardly know of their pixels' luck.
  std::vector<double> squares_;
};

}  // namespace parray
