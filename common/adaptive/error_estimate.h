#pragma once

#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include "common/adaptive/error_figures.h"
#include "common/image/framebuffer.h"

namespace parray::adaptive {

/// The error of a picture, with that of each pixel.
struct ErrorEstimate : ErrorFigures {
  /// Half-width of each pixel's 95 % confidence interval: 3 values (R, G, B) per pixel, image
  /// order. Contains only the rows that the estimate used. Empty: not estimated.
  std::vector<float> half_width;
};

/// Estimates the error of the picture, the mean of both replicates, from the differences of each
/// pixel's replicates. Valid for every sampler. See common/image/pixel_sums.h and, for the
/// half-widths, common/adaptive/noise_model.h. All errors are unknown if a pixel of the picture has
/// fewer than 2 samples. `high` includes light that no sample has shown, by the rule of three: an
/// event that none of n samples showed has, with 95 % confidence, a probability of at most 3 / n.
/// Non-finite samples count as black. The result depends on the arguments alone and has the same
/// bits on every machine.
///
/// `stride` must be > 0. The error is that of rows 0, `stride`, 2 * `stride` and so on. So with
/// `stride` > 1 the interval is wider, and `half_width` contains only these rows.
ErrorEstimate estimate_error(const FramebufferView& state, std::size_t stride = 1);
/// Does the same without half-widths, which cost most of the time.
ErrorEstimate estimate_rmse(const FramebufferView& state, std::size_t stride = 1);

/// The error of the pixels that have two samples or more, without half-widths.
struct PartialError {
  ErrorFigures error;
  /// Such pixels of the whole picture, whatever the stride, divided by all its pixels. 0: the error
  /// is unknown.
  double share = 0;
};
/// Estimates the error of the pixels that have two samples or more. The error is that of such
/// pixels in rows 0, `stride`, 2 * `stride` and so on. It is unknown if these rows have none.
PartialError estimate_rmse_so_far(const FramebufferView& state, std::size_t stride = 1);

/// Returns the mean square error, over the values of a picture, of light that no sample has shown,
/// by the rule of three (see estimate_error()). `largest`: the largest radiance of a sample.
/// `counts`: samples of each pixel, at least 1.
double unseen_square(double largest, std::span<const std::uint32_t> counts);

/// The name of the method of ErrorEstimate in reports.
inline constexpr std::string_view error_method = "replicates";

}  // namespace parray::adaptive
