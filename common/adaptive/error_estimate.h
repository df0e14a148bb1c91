#pragma once

#include <string_view>
#include <vector>

#include "common/image/framebuffer.h"

namespace parray::adaptive {

/// How far a picture is from what it would be with endless samples, as far as its own samples tell.
struct ErrorFigures {
  /// Root mean square over pixels and channels, linear radiance; and the interval that it lies in,
  /// 95 % of the time. Negative where unknown (a pixel with less than 2 samples).
  double rmse = -1;
  double low = -1;
  double high = -1;
  /// Of the half-widths of all pixels and channels.
  double half_width_p50 = -1;
  double half_width_p99 = -1;

  [[nodiscard]] bool known() const { return rmse >= 0; }
};

struct ErrorEstimate : ErrorFigures {
  /// Of each pixel's 95 % interval: 3 values (R, G, B) a pixel, image order.
  std::vector<float> half_width;
};

/// From the differences of each pixel's two replicates, whatever the sampler; see
/// common/image/pixel_sums.h and, for the half-widths, common/adaptive/noise_model.h. `high`
/// includes what no sample has shown, by the rule of three. Samples that were not finite count as
/// black. A function of its arguments alone, in arithmetic that is the same everywhere.
/// From every `stride`-th row: the interval is wider, and half-widths are those of these rows.
ErrorEstimate estimate_error(const FramebufferView& state, std::size_t stride = 1);
/// The same without half-widths, which cost most of the time.
ErrorEstimate estimate_rmse(const FramebufferView& state, std::size_t stride = 1);

/// Of ErrorEstimate, as reports name it.
inline constexpr std::string_view error_method = "replicates";

}  // namespace parray::adaptive
