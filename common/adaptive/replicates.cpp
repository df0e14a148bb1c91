#include "common/adaptive/replicates.h"

#include <algorithm>
#include <cmath>

#include "common/adaptive/pixel_noise.h"
#include "common/image/radiance_scale.h"

namespace parray::adaptive {
namespace {

void put_means(const FramebufferView& state, Replicates& out) {
  const RadianceScale scale(state.largest_radiance);
  for (std::size_t pixel = 0; pixel < state.pixels.size(); ++pixel) {
    const PixelSums& sums = state.pixels[pixel];
    const std::uint32_t count = state.counts[pixel];
    for (std::size_t c = 0; c < 3; ++c) {
      const std::uint64_t even = sums.sum[c] - sums.odd[c];
      const std::uint32_t evens = std::max(count - count / 2, 1U);
      const std::uint64_t odd = count > 1 ? sums.odd[c] : even;
      out.mean[0][3 * pixel + c] = static_cast<float>(scale.mean(even, evens));
      out.mean[1][3 * pixel + c] = static_cast<float>(scale.mean(odd, std::max(count / 2, 1U)));
    }
  }
}

void put_noise(const FramebufferView& state, std::vector<float>& out) {
  std::vector<double> independent(out.size());  // mean square errors of independent samples
  struct Sums {
    double squares = 0;
    double variances = 0;
  };
  std::vector<Sums> bands(noise_bands(state.height));
  const auto visit = [&](std::size_t band, std::size_t y, const NoiseNearby& row) {
    auto& [squares, variances] = bands[band];
    for (std::size_t x = 0; x < state.width; ++x) {
      const double count = row.own.count[3 * x];
      double around = 0;
      for (std::size_t value = 3 * x; value < 3 * x + 3; ++value) {
        squares += row.own.difference[value] * row.own.difference[value];
        variances += row.own.variance[value] / count;
        around += row.around.mean[value];
      }
      independent[y * state.width + x] = around / 3 * 2 / count;  // a half has count / 2
    }
  };
  visit_noise(state, 1, NeighbourhoodSize::windows, visit);
  double squares = 0;
  double variances = 0;
  for (const Sums& band : bands) {
    squares += band.squares;
    variances += band.variances;
  }
  // Mean square error of the sampler relative to independent samples.
  const double gain = variances > 0 ? squares / variances : 0;
  for (std::size_t i = 0; i < out.size(); ++i) {
    out[i] = static_cast<float>(std::sqrt(independent[i] * gain));
  }
}

}  // namespace

Replicates replicates_of(const FramebufferView& state) {
  Replicates out;
  for (std::vector<float>& mean : out.mean) mean.resize(3 * state.pixels.size());
  out.noise.resize(state.pixels.size());
  put_means(state, out);
  if (std::ranges::all_of(state.counts, [](std::uint32_t count) { return count >= 2; })) {
    put_noise(state, out.noise);
  }
  return out;
}

}  // namespace parray::adaptive
