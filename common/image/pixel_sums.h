#pragma once

#include <array>
#include <cstdint>

#include "common/image/radiance_scale.h"

namespace parray {

/// What a pixel remembers of its samples: per channel the sum and the sum of squares, in the
/// fixed point of RadianceScale. Adding is exact and associative.
struct PixelSums {
  std::array<std::uint64_t, 3> sum{};
  std::array<std::uint64_t, 3> sum_of_squares{};

  void add(const std::array<std::uint64_t, 3>& fixed) {
    for (std::size_t channel = 0; channel < 3; ++channel) {
      sum[channel] += fixed[channel];
      sum_of_squares[channel] += RadianceScale::square_of(fixed[channel]);
    }
  }

  PixelSums& operator+=(const PixelSums& other) {
    for (std::size_t channel = 0; channel < 3; ++channel) {
      sum[channel] += other.sum[channel];
      sum_of_squares[channel] += other.sum_of_squares[channel];
    }
    return *this;
  }

  friend bool operator==(const PixelSums&, const PixelSums&) = default;
};

/// Counts of the work behind some samples. Adding is exact and associative.
struct TraceCounts {
  std::uint64_t samples = 0;
  std::uint64_t rays = 0;       ///< path segments traced
  std::uint64_t nonfinite = 0;  ///< samples excluded because they were NaN or infinite

  TraceCounts& operator+=(const TraceCounts& other) {
    samples += other.samples;
    rays += other.rays;
    nonfinite += other.nonfinite;
    return *this;
  }

  friend bool operator==(const TraceCounts&, const TraceCounts&) = default;
};

}  // namespace parray
