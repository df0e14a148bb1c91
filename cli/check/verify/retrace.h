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

/// A pixel to trace. The caller sets x, y and samples; retrace() sets the other members.
struct RetracedPixel {
  std::uint32_t x = 0;
  std::uint32_t y = 0;
  std::uint32_t samples = 0;    ///< number of its samples, which are numbered from 0
  std::array<float, 3> mean{};  ///< linear RGB; samples that are not finite are left out
  float alpha = 1;              ///< of a transparent picture, whose `mean` is premultiplied
  PixelSums sums{};             ///< sums of the samples, including the background
};

/// Returns `count` distinct random numbers below `total`, sorted, or all numbers below `total` if
/// `count` is larger. Every set has the same probability. The same seed gives the same numbers on
/// every machine.
std::vector<std::uint64_t> choose(std::uint64_t count, std::uint64_t total, std::uint64_t seed);

/// Traces the samples of the pixels and sets `mean` and `sums`. The pixels must be distinct and
/// sorted by row, then column. `scale`: RadianceScale of the scene's largest_radiance().
/// `transparent`: removes the background from `mean` and sets `alpha` (transparency.h).
void retrace(const PathTracer& tracer, const RadianceScale& scale, std::span<RetracedPixel> pixels,
             int threads, bool transparent = false);

/// Returns the share of wrong pixels in a picture, 0 to 1, for which `count` random pixels contain
/// at least one wrong pixel with a probability of 95 %. `count` is at least 1.
double share_found(std::uint64_t count);

}  // namespace parray::verify
