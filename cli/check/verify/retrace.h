#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "common/image/pixel_sums.h"
#include "common/image/radiance_scale.h"
#include "common/trace/integrator/path_tracer.h"

/// Traces single pixels of a finished picture again.
namespace parray::verify {

struct RetracedPixel {
  std::uint32_t x = 0;
  std::uint32_t y = 0;
  std::uint32_t samples = 0;    ///< how many samples the pixel has; they have the numbers from 0 on
  std::array<float, 3> mean{};  ///< the picture's value; samples that are not finite are left out
  float alpha = 1;              ///< of a transparent picture, whose `mean` is premultiplied
  PixelSums sums{};             ///< sums of the samples, including the background
};

/// Returns `count` distinct numbers below `total`, sorted, or all numbers if `count` is larger.
/// Every set has the same probability. The same seed gives the same numbers on every machine.
std::vector<std::uint64_t> choose(std::uint64_t count, std::uint64_t total, std::uint64_t seed);

/// Sets `mean` and `sums` of the pixels, which must be distinct and sorted by row, then column.
/// Traces the pixels of a row together, which is faster. `scale` belongs to the scene.
/// `transparent`: removes the background and sets alpha (cli/output/picture/transparency.h).
void retrace(const PathTracer& tracer, const RadianceScale& scale, std::span<RetracedPixel> pixels,
             int threads, bool transparent = false);

/// Returns the share of wrong pixels, 0 to 1, of which `count` random pixels contain at least one
/// with a probability of 95 %.
double share_found(std::uint64_t count);

}  // namespace parray::verify
