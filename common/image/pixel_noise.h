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

/// What the up to 8 pixels around a pixel say about its noise, of one channel: all that can be
/// known of it without asking its own samples, whose luck would decide the answer.
struct Surroundings {
  double mean = 0;  ///< variance
  /// The largest variance that two opposite neighbours reach: high on an edge, low beside it.
  double ridge = 0;
};

struct NoiseNearby {
  PixelNoise own;
  std::array<Surroundings, 3> around{};
};

/// Of rows 0 .. 2, the pixel in row 1: variance(row, column).
template <typename Variance>
Surroundings surroundings_inside(const Variance& variance, std::size_t x) {
  Surroundings around;
  for (const auto& [row, column] :
       {std::pair<std::size_t, std::size_t>{0, x - 1}, {0, x}, {0, x + 1}, {1, x - 1}}) {
    const double one = variance(row, column);
    const double opposite = variance(2 - row, 2 * x - column);
    around.mean += (one + opposite) / 8;
    around.ridge = std::max(around.ridge, std::min(one, opposite));
  }
  return around;
}

/// The same where some neighbours are missing.
template <typename Variance>
Surroundings surroundings_at_border(const Variance& variance, std::size_t x, std::size_t width,
                                    bool first_row, bool last_row) {
  Surroundings around;
  int others = 0;
  for (std::size_t row = first_row ? 1 : 0; row < (last_row ? 2 : 3); ++row) {
    for (std::size_t column = x > 0 ? x - 1 : 0; column <= x + 1 && column < width; ++column) {
      if (row != 1 || column != x) {
        around.mean += variance(row, column);
        ++others;
      }
    }
  }
  around.mean = others > 0 ? around.mean / others : variance(1, x);
  around.ridge = around.mean;
  return around;
}

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
      NoiseNearby nearby{rows[1][x], {}};
      const bool inside = !first && !last && x > 0 && x + 1 < width;
      for (std::size_t channel = 0; channel < 3; ++channel) {
        const auto variance = [&](std::size_t row, std::size_t column) {
          return rows[row][column].variance[channel];
        };
        nearby.around[channel] = inside ? surroundings_inside(variance, x)
                                        : surroundings_at_border(variance, x, width, first, last);
      }
      visit(y * width + x, nearby);
    }
    std::swap(rows[0], rows[1]);
    std::swap(rows[1], rows[2]);
  }
}

}  // namespace parray
