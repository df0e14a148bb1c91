#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <utility>
#include <vector>

#include "common/image/passes.h"
#include "common/image/pixel_sums.h"
#include "common/image/radiance_scale.h"

namespace parray {

/// What a pixel's own samples say about its noise, by channel.
struct PixelNoise {
  /// Of one sample, unbiased, in squared radiance; >= 0.
  std::array<double, 3> variance{};
  /// Of the means of the two replicates, scaled so that its mean square is that of the error of the
  /// pixel's mean, whatever the sampler; in radiance.
  std::array<double, 3> difference{};
};

/// Of a pixel with `count` samples; zeros if less than 2. The replicates A and B have a and b
/// samples, and the difference is (A - B) sqrt(ab) / (a + b): with a = b, half of A - B, where the
/// error of the mean is half of the sum of theirs. Arithmetic that is the same everywhere.
PixelNoise noise_of(const PixelSums& pixel, std::uint32_t count, const RadianceScale& scale);

/// A pixel's noise, and the mean variance of the up to 8 pixels around it: what can be known of its
/// noise without asking its own samples, whose luck would decide the answer.
struct NoiseNearby {
  PixelNoise own;
  std::array<double, 3> around{};
};

/// Calls visit(index, NoiseNearby) for each pixel, by image row. Memory: three rows.
template <typename Visit>
void visit_noise(const PictureState& state, Visit&& visit) {
  const RadianceScale scale(state.largest_radiance);
  const std::size_t width = state.width;
  const auto read = [&](std::size_t y, std::vector<PixelNoise>& row) {
    for (std::size_t x = 0; x < width; ++x) {
      row[x] = noise_of(state.pixels[y * width + x], state.counts[y * width + x], scale);
    }
  };
  std::array<std::vector<PixelNoise>, 3> rows;
  rows.fill(std::vector<PixelNoise>(width));
  read(0, rows[1]);
  for (std::size_t y = 0; y < state.height; ++y) {
    const bool first = y == 0;
    const bool last = y + 1 == state.height;
    if (!last) {
      read(y + 1, rows[2]);
    }
    for (std::size_t x = 0; x < width; ++x) {
      const std::size_t left = x == 0 ? 0 : x - 1;
      const std::size_t right = x + 1 == width ? x : x + 1;
      NoiseNearby nearby{rows[1][x], {}};
      int others = 0;
      for (std::size_t row = first ? 1 : 0; row < (last ? 2 : 3); ++row) {
        for (std::size_t column = left; column <= right; ++column) {
          if (row == 1 && column == x) {
            continue;
          }
          ++others;
          for (std::size_t channel = 0; channel < 3; ++channel) {
            nearby.around[channel] += rows[row][column].variance[channel];
          }
        }
      }
      for (std::size_t channel = 0; channel < 3; ++channel) {
        nearby.around[channel] =
            others > 0 ? nearby.around[channel] / others : nearby.own.variance[channel];
      }
      visit(y * width + x, nearby);
    }
    std::swap(rows[0], rows[1]);
    std::swap(rows[1], rows[2]);
  }
}

}  // namespace parray
