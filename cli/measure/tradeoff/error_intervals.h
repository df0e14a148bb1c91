#pragma once

#include <array>
#include <cstddef>

#include "common/adaptive/error_estimate.h"

namespace parray::tradeoff {

/// Shares of intervals that are asked to hold, and half the width of each in standard deviations of
/// a normal.
inline constexpr std::array<double, 5> interval_levels = {0.5, 0.8, 0.9, 0.95, 0.99};
inline constexpr std::array<double, 5> normal_half_widths = {0.674490, 1.281552, 1.644854, 1.959964,
                                                             2.575829};
inline constexpr std::size_t stated_level = 3;  ///< of ErrorEstimate: 95 %

/// Intervals of other levels than the 95 % that pictures state. These promise at least their 95 %;
/// narrower ones are meant to hold as often as they say, no more. From the picture alone, whatever
/// the sampler; wider ones are the stated ones, widened as a normal's.
class ErrorIntervals {
 public:
  /// `error` is estimate_error(state), and known.
  ErrorIntervals(const FramebufferView& state, const ErrorEstimate& error);

  /// By what half-widths of pixels are to be multiplied for a level, by its number. Below 95 %:
  /// that share of the half differences (A - B) / 2 of all pixels' replicates is as wide at most.
  /// They and the errors (A + B) / 2 - mu are alike but for the sign of a half (noise_model.h), so
  /// their shape is that of the errors. Values whose replicates agree to the last bit have no say:
  /// had they no noise, they need no interval, and had they not seen it yet, it would seem to be 0.
  [[nodiscard]] double scale(std::size_t level) const { return scales_[level]; }

  struct Interval {
    double low = 0;
    double high = 0;
  };
  /// Of the picture's RMSE. Below 95 %: by a variance of its square between two that bracket it,
  /// the geometric mean of both. With u and w the errors of a pixel's replicates, that variance is
  /// the sum over pixels of the mean of (uw)^2 (error_estimate.cpp). By each pixel's own samples,
  /// and by how alike its channels are, it comes out too high: where these show a rare bright one,
  /// both factors do. By the products of differences of pixels side by side, which have no noise in
  /// common, it comes out too low: noise varies from pixel to pixel. What no sample has shown is
  /// left out: that is for the wide ones.
  [[nodiscard]] Interval rmse(std::size_t level) const { return rmse_[level]; }

 private:
  std::array<double, 5> scales_{};
  std::array<Interval, 5> rmse_{};
};

}  // namespace parray::tradeoff
