#pragma once

#include <array>
#include <cstddef>

#include "common/adaptive/error_estimate.h"

namespace parray::tradeoff {

/// Confidence levels, and the half-width of each in standard deviations of a normal distribution.
inline constexpr std::array<double, 5> interval_levels = {0.5, 0.8, 0.9, 0.95, 0.99};
inline constexpr std::array<double, 5> normal_half_widths = {0.674490, 1.281552, 1.644854, 1.959964,
                                                             2.575829};
inline constexpr std::size_t stated_level = 3;  ///< the level of ErrorEstimate, 95 %

/// Confidence intervals of other levels than the 95 % that pictures state. Stated intervals hold at
/// least 95 % of the time; narrower ones should hold exactly as often as their level. They come
/// from the picture alone, for any sampler. Wider intervals are the stated ones, widened as for a
/// normal distribution.
class ErrorIntervals {
 public:
  /// `error` must be estimate_error(state), and error.known() must be true.
  ErrorIntervals(const FramebufferView& state, const ErrorEstimate& error);

  /// Returns the factor for the stated half-widths of pixels at a level, by its index. Below 95 %
  /// it is a quantile, over the values of all pixels, of |A - B| / 2 divided by the stated
  /// half-width. A and B are the replicates of a value. (A - B) / 2 has the same distribution as
  /// the error (A + B) / 2 - mu, apart from the sign of one half (noise_model.h). Values whose
  /// replicates agree to the last bit do not count: they have no noise, or have not seen it yet.
  [[nodiscard]] double scale(std::size_t level) const { return scales_[level]; }

  struct Interval {
    double low = 0;
    double high = 0;
  };
  /// Returns the interval of the picture's RMSE. Below 95 % its width follows from the variance of
  /// the square error: the geometric mean of an upper and a lower estimate. With u and w the errors
  /// of a pixel's replicates, that variance is the sum over pixels of the mean of (uw)^2
  /// (error_estimate.cpp). The estimate from each pixel's own samples, and the correlation of its
  /// channels, is too high: a rare bright sample raises both factors. The estimate from products of
  /// differences of neighbouring pixels, which share no noise, is too low: noise varies from pixel
  /// to pixel. Light that no sample has shown is left to the wide intervals.
  [[nodiscard]] Interval rmse(std::size_t level) const { return rmse_[level]; }

 private:
  std::array<double, 5> scales_{};
  std::array<Interval, 5> rmse_{};
};

}  // namespace parray::tradeoff
