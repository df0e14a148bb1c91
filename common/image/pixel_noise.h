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
  std::array<double, 3> mean{};  ///< radiance
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
  double radiance = 0;  ///< mean
  double mean = 0;      ///< variance
  /// The largest variance that two opposite neighbours reach: high on an edge, low beside it.
  double ridge = 0;
};

struct NoiseNearby {
  PixelNoise own;
  std::array<Surroundings, 3> around{};
};

/// Calls visit(index, NoiseNearby) for each pixel of every `stride`-th row, in order. Beyond the
/// border the picture is mirrored. Memory: three rows.
template <typename Visit>
void visit_noise(const PictureState& state, std::size_t stride, Visit&& visit) {
  const RadianceScale scale(state.largest_radiance);
  const std::size_t width = state.width;
  std::array<std::vector<PixelNoise>, 3> rows;
  rows.fill(std::vector<PixelNoise>(width));
  std::size_t have = 0;
  const auto row = [&](std::size_t y) -> const std::vector<PixelNoise>& {
    for (; have <= y; ++have) {
      if (have + 3 > y) {
        for (std::size_t x = 0; x < width; ++x) {
          const std::size_t i = have * width + x;
          rows[have % 3][x] = noise_of(state.pixels[i], state.counts[i], scale);
        }
      }
    }
    return rows[y % 3];
  };
  const auto before = [](std::size_t i, std::size_t size) {
    return i > 0 ? i - 1 : std::min<std::size_t>(1, size - 1);
  };
  const auto after = [](std::size_t i, std::size_t size) {
    return i + 1 < size ? i + 1 : i - std::min<std::size_t>(1, i);
  };
  for (std::size_t y = 0; y < state.height; y += stride) {
    const PixelNoise* const above = row(before(y, state.height)).data();
    const PixelNoise* const below = row(after(y, state.height)).data();
    const PixelNoise* const here = row(y).data();
    for (std::size_t x = 0; x < width; ++x) {
      const std::size_t left = before(x, width);
      const std::size_t right = after(x, width);
      NoiseNearby nearby{here[x], {}};
      for (std::size_t channel = 0; channel < 3; ++channel) {
        Surroundings& around = nearby.around[channel];
        const auto add = [&](const PixelNoise& one, const PixelNoise& opposite) {
          around.radiance += (one.mean[channel] + opposite.mean[channel]) / 8;
          around.mean += (one.variance[channel] + opposite.variance[channel]) / 8;
          around.ridge =
              std::max(around.ridge, std::min(one.variance[channel], opposite.variance[channel]));
        };
        add(above[left], below[right]);
        add(above[x], below[x]);
        add(above[right], below[left]);
        add(here[left], here[right]);
      }
      visit(y * width + x, nearby);
    }
  }
}

}  // namespace parray
