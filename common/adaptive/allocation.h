#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "common/adaptive/sample_shares.h"
#include "common/image/framebuffer.h"

namespace parray::adaptive {

/// Where the samples of a picture serve best, from what the pixels around each have shown. A
/// pixel's own samples have a say only as far as their number makes them: their mean would be
/// biased if their luck decided how many follow.
///
/// For the least mean square error a pixel's count is in proportion to the deviation of its samples
/// (Neyman, "On the two different aspects of the representative method", 1934), for equal
/// half-widths to their variance.
class Allocation {
 public:
  /// Each pixel of `state` has at least 2 samples. Of every `stride`-th row: of what follows, "all
  /// pixels" are those of these rows. From a stride of 2 on, the 8 next to a pixel speak for all
  /// that is around it: good enough to foresee what samples will bring, not to place them.
  Allocation(const FramebufferView& state, bool equal_half_widths, std::size_t stride = 1);

  [[nodiscard]] SampleShares shares() const { return {counts_, weights_}; }
  [[nodiscard]] const std::vector<float>& weights() const { return weights_; }  ///< of shares()

  /// Samples, all pixels together, that are expected to bring the mean square error, or the square
  /// of the half-width that 99 % of the pixels have, to `share` of what it is, 0 < share < 1.
  [[nodiscard]] double total_for_square_error(double share) const;
  [[nodiscard]] double total_for_square_half_width(double share) const;
  /// The other way round: what `total` samples, no fewer than there are, leave of the mean square
  /// error; 1 if there is none.
  [[nodiscard]] double share_of_square_error(double total) const;

  /// Rays that it takes to bring the mean square error to `share` of what it is, over those of
  /// equal numbers of samples for all pixels, which have equal numbers now. `rays`: of a sample, on
  /// average so far; those of a pixel without noise, which sees the sky, count as one.
  [[nodiscard]] double relative_cost(double share, double rays) const;

 private:
  /// Sum of the expected square errors of all pixels and channels at a level of shares().
  [[nodiscard]] double square_error_at(double level) const;
  [[nodiscard]] double level_for_square_error(double share) const;

  std::vector<std::uint32_t> counts_;
  std::vector<float> weights_;  ///< of squares, or of their roots, over the largest radiance's
  /// In the same unit: mean square errors times counts by the pixels' own variances: each says
  /// little, their sum is right, since weights hardly know of their pixels' luck.
  std::vector<float> squares_;
  std::vector<char> quiet_;  ///< 1 for pixels with next to no noise
};

/// Whether the next samples serve so much better where the noise is that all it takes to place them
/// is well paid. All pixels have the same number of samples; `rays`: see relative_cost().
bool adaptive_pays(const Allocation& allocation, double rays);

}  // namespace parray::adaptive
