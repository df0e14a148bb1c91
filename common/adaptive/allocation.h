#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "common/adaptive/sample_shares.h"
#include "common/image/framebuffer.h"

namespace parray::adaptive {

/// Computes where further samples of a picture help most, from the noise around each pixel. A
/// pixel's own samples enter only by their number, and by their variance as far as the bias stays
/// below 0.1 %. If their values decided how many samples follow, the pixel's mean would be biased.
///
/// For the least mean square error, a pixel's count is proportional to the standard deviation of
/// its samples (Neyman, "On the two different aspects of the representative method", 1934). For
/// equal half-widths, the count is proportional to their variance.
class Allocation {
 public:
  /// `equal_half_widths`: places samples so that all pixels get equal half-widths of their
  /// confidence intervals; otherwise so that the mean square error is least. Handles rows
  /// 0, `stride`, 2 * `stride` and so on of `state`. Each pixel must have at least 2 samples.
  /// Below, "all pixels" means the pixels of these rows. With a stride of 2 or more, only the 8
  /// neighbours of a pixel stand for its surroundings. That is accurate enough to predict the
  /// effect of more samples, but not to place them.
  Allocation(const FramebufferView& state, bool equal_half_widths, std::size_t stride = 1);

  /// Returns the present counts of all pixels with the weights by which further samples are placed.
  /// The result refers to this object.
  [[nodiscard]] SampleShares shares() const { return {counts_, weights_}; }
  [[nodiscard]] const std::vector<float>& weights() const { return weights_; }  ///< of shares()

  /// Return the total number of samples, over all pixels, that is expected to reduce an error to
  /// `share` of its present value, 0 < share < 1. The error is the mean square error, or the square
  /// of the largest half-width of the 99 % of the pixels with the smallest half-widths. The second
  /// function needs an object with `equal_half_widths`.
  [[nodiscard]] double total_for_square_error(double share) const;
  [[nodiscard]] double total_for_square_half_width(double share) const;
  /// Returns the inverse: the share of the present mean square error that is expected to remain
  /// with `total` samples. `total` must not be below the present number. Returns 1 if there is no
  /// error.
  [[nodiscard]] double share_of_square_error(double total) const;

  /// Returns the cost of reducing the mean square error to `share` of its present value, divided by
  /// the cost of the same reduction with equal numbers of samples for all pixels. Cost is counted
  /// in rays. All pixels must have equal numbers of samples now. `rays` is the average number of
  /// rays per sample so far. A sample of a pixel without noise, which sees the sky, counts as one
  /// ray.
  [[nodiscard]] double relative_cost(double share, double rays) const;

 private:
  /// Returns the sum of the expected square errors of all pixels and channels if the pixels have
  /// the samples of this level: see SampleShares::count_at().
  [[nodiscard]] double square_error_at(double level) const;
  [[nodiscard]] double level_for_square_error(double share) const;

  std::vector<std::uint32_t> counts_;
  /// Variance around each pixel (equal half-widths) or its root, in units of the largest radiance.
  std::vector<float> weights_;
  /// Mean square error times count of each pixel, from its own variance, in the same unit. The
  /// value of one pixel is very uncertain. The sum over all pixels is accurate, because the weights
  /// hardly depend on the chance errors of the pixels themselves.
  std::vector<float> squares_;
  std::vector<char> quiet_;  ///< 1: the pixel has almost no noise, as where it sees only the sky
};

}  // namespace parray::adaptive
