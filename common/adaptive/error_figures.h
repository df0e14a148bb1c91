#pragma once

namespace parray::adaptive {

/// The distance of a picture from its limit with infinitely many samples, estimated from its own
/// samples.
struct ErrorFigures {
  /// Root mean square error over pixels and channels, in linear radiance. `low` and `high` bound
  /// its 95 % confidence interval. All three are negative if they are unknown, because pixels have
  /// fewer than 2 samples.
  double rmse = -1;
  double low = -1;
  double high = -1;
  /// Median and 99th percentile of the half-widths of all pixels and channels, in linear radiance;
  /// negative: unknown.
  double half_width_p50 = -1;
  double half_width_p99 = -1;

  [[nodiscard]] bool known() const { return rmse >= 0; }
  friend bool operator==(const ErrorFigures&, const ErrorFigures&) = default;
};

}  // namespace parray::adaptive
