#pragma once

#include <array>
#include <cstdint>

#include "common/image/radiance_scale.h"
#include "common/math/inline.h"

namespace parray::image {

/// The sums of a pixel's samples. Each channel (R, G, B) has the sum, the sum of squares
/// (RadianceScale::square_of()), and the sum of the samples with odd numbers, in the fixed point of
/// RadianceScale. Addition is exact and associative.
///
/// Samples with even and with odd numbers form two independent replicates of the pixel, with any
/// sampler. Their difference shows the size of the pixel's error.
struct PixelSums {
  std::array<std::uint64_t, 3> sum{};
  std::array<std::uint64_t, 3> sum_of_squares{};
  std::array<std::uint64_t, 3> odd{};

  /// Adds sample number `sample`, counted from 0, with the radiance `fixed` in fixed point.
  void add(const std::array<std::uint64_t, 3>& fixed, std::uint32_t sample) {
    const std::uint64_t if_odd = 0 - std::uint64_t{sample & 1};
    for (std::size_t channel = 0; channel < 3; ++channel) {
      sum[channel] += fixed[channel];
      sum_of_squares[channel] += RadianceScale::square_of(fixed[channel]);
      odd[channel] += fixed[channel] & if_odd;
    }
  }

  PixelSums& operator+=(const PixelSums& other) {
    for (std::size_t channel = 0; channel < 3; ++channel) {
      sum[channel] += other.sum[channel];
      sum_of_squares[channel] += other.sum_of_squares[channel];
      odd[channel] += other.odd[channel];
    }
    return *this;
  }

  friend bool operator==(const PixelSums&, const PixelSums&) = default;
};

/// The background samples of a pixel: those with a camera ray that hits nothing.
struct SkySamples {
  std::uint32_t count = 0;
  /// Sum of their radiance, in the fixed point of RadianceScale.
  std::array<std::uint64_t, 3> sum{};

  friend bool operator==(const SkySamples&, const SkySamples&) = default;
};

/// Counts of the work behind some samples. Addition is exact and associative.
struct TraceCounts {
  std::uint64_t samples = 0;  ///< including non-finite ones
  /// Ray segments of all paths. A straight way through several surfaces of one glass body has a
  /// segment per surface (InsideStack), so a path may have more than max_depth: at most
  /// rays_of_segment for each segment that max_depth counts.
  std::uint64_t rays = 0;
  std::uint64_t nonfinite = 0;  ///< samples excluded because they were NaN or infinite
  /// A bound of the light that max_depth cut off, under a sky of radiance 1. Each path that had not
  /// ended by then adds the largest channel of its throughput (the product of the albedos on it),
  /// in units of lost_unit, rounded up.
  std::uint64_t lost = 0;

  static constexpr std::uint64_t rays_of_segment = 65;  ///< most_crossings of ray.h, and one
  static constexpr double lost_unit = 0x1p-24;
  /// Returns what a path adds to `lost`. `largest`: the largest channel of its throughput, 0 .. 1.
  static PARRAY_INLINE std::uint64_t lost_of(double largest) {
    return static_cast<std::uint64_t>(largest / lost_unit) + 1;
  }

  TraceCounts& operator+=(const TraceCounts& other) {
    samples += other.samples;
    rays += other.rays;
    nonfinite += other.nonfinite;
    lost += other.lost;
    return *this;
  }

  /// Subtracts `other`, which must be a part of these counts.
  TraceCounts& operator-=(const TraceCounts& other) {
    samples -= other.samples;
    rays -= other.rays;
    nonfinite -= other.nonfinite;
    lost -= other.lost;
    return *this;
  }

  friend bool operator==(const TraceCounts&, const TraceCounts&) = default;
};

}  // namespace parray::image
