#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "common/adaptive/sample_shares.h"
#include "common/image/framebuffer.h"

namespace parray::adaptive {

/// Computes where further samples of a picture help most, from the noise around each pixel. A
/// pixel's own samples count only through their number. If their values decided how many samples
/// follow, the pixel's mean would be biased.
///
/// For the least mean square error, a pixel's count is proportional to the standard deviation of
/// its samples (Neyman, "On the two different aspects of the representative method", 1934). For
/// equal half-widths, the count is proportional to their variance.
class Allocation {
 public:
  /// Reads every `stride`-th row of `state`. Each pixel must have at least 2 samples. Below, "all
  /// pixels" means the pixels of these rows. With a stride of 2 or more, only the 8 neighbours of a
  /// pixel stand for its surroundings. That is accurate enough to predict the effect of more
  /// samples, but not to place them.
  Allocation(const FramebufferView& state, bool equal_half_widths, std::size_t stride = 1);

  [[nodiscard]] SampleShares shares() const { return {counts_, weights_}; }
  [[nodiscard]] const std::vector<float>& weights() const { return weights_; }  ///< of shares()

  /// Return the total number of samples, over all pixels, that is expected to reduce an error to
  /// `share` of its present value, 0 < share < 1. The error is the mean square error, or the square
  /// of the half-width that 99 % of the pixels stay within.
  [[nodiscard]] double total_for_square_error(double share) const;
  [[nodiscard]] double total_for_square_half_width(double share) const;
  /// Returns the inverse: the share of the present mean square error that is expected to remain
  /// with `total` samples. `total` must not be below the present number. Returns 1 if there is no
  /// error.
  [[nodiscard]] double share_of_square_error(double total) const;

  /// Returns the cost of reducing the mean square error to `share` of its present value, relative
  /// to equal numbers of samples for all pixels. Cost is counted in rays. All pixels must have
  /// equal numbers of samples now. `rays` is the average number of rays per sample so far. A sample
  /// of a pixel without noise, which sees the sky, counts as one ray.
  [[nodiscard]] double relative_cost(double share, double rays) const;

 private:
  /// Returns the sum of the expected square errors of all pixels and channels at a level of
  /// shares().
  [[nodiscard]] double square_error_at(double level) const;
  [[nodiscard]] double level_for_square_error(double share) const;

  std::vector<std::uint32_t> counts_;
  std::vector<float> weights_;  ///< of squares or of their roots, in units of the largest radiance
  /// Mean square error times count of each pixel, from its own variance, in the same unit. A single
  /// value says little. Their sum is right, because the weights hardly depend on the pixels' own
  /// luck.
  std::vector<float> squares_;
  std::vector<char> quiet_;  ///< 1 for pixels with next to no noise
};

/// Returns whether adaptive placement of the next samples saves clearly more than it costs. All
/// pixels must have the same number of samples. `rays`: see relative_cost().
bool adaptive_pays(const Allocation& allocation, double rays);

}  // namespace parray::adaptive
