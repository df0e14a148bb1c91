#pragma once

#include <string_view>
#include <vector>

#include "common/image/framebuffer.h"

namespace parray::adaptive {

/// The distance of a picture from its limit with infinitely many samples, estimated from its own
/// samples.
struct ErrorFigures {
  /// Root mean square error over pixels and channels, in linear radiance. `low` and `high` bound
  /// its 95 % confidence interval. All three are negative if they are unknown, because a pixel has
  /// fewer than 2 samples.
  double rmse = -1;
  double low = -1;
  double high = -1;
  /// Median and 99th percentile of the half-widths of all pixels and channels, in linear radiance;
  /// negative: unknown.
  double half_width_p50 = -1;
  double half_width_p99 = -1;

  [[nodiscard]] bool known() const { return rmse >= 0; }
};

/// The error of a picture, with that of each pixel.
struct ErrorEstimate : ErrorFigures {
  /// Half-width of each pixel's 95 % confidence interval: 3 values (R, G, B) per pixel, image
  /// order. Empty: not estimated.
  std::vector<float> half_width;
};

/// Estimates the error from the differences of each pixel's two replicates, with any sampler. See
/// common/image/pixel_sums.h and, for the half-widths, common/adaptive/noise_model.h. `high`
/// includes light that no sample has shown, by the rule of three: an event that none of n samples
/// showed has, with 95 % confidence, a probability of at most 3 / n. Non-finite samples count as
/// black. The result depends on the arguments alone and has the same bits on every machine. With
/// `stride` > 1 only every `stride`-th row is read: the interval is wider, and the half-widths are
/// those of these rows.
ErrorEstimate estimate_error(const FramebufferView& state, std::size_t stride = 1);
/// Estimates the error without half-widths, which cost most of the time.
ErrorEstimate estimate_rmse(const FramebufferView& state, std::size_t stride = 1);

/// The error of the pixels that have two samples or more, without half-widths.
struct PartialError {
  ErrorFigures error;
  double share = 0;  ///< such pixels divided by all pixels; 0: the error is unknown
};
/// Estimates the error of the pixels that have two samples or more. Reads only every `stride`-th
/// row.
PartialError estimate_rmse_so_far(const FramebufferView& state, std::size_t stride = 1);

/// The name of the method of ErrorEstimate in reports.
inline constexpr std::string_view error_method = "replicates";

}  // namespace parray::adaptive
