#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "common/image/pixel_sums.h"
#include "common/image/radiance_scale.h"
#include "common/trace/integrator/path_tracer.h"

/// Single pixels of a finished picture, traced again.
namespace parray::verify {

struct RetracedPixel {
  std::uint32_t x = 0;
  std::uint32_t y = 0;
  std::uint32_t samples = 0;    ///< that its mean is of: numbers 0 .. samples - 1
  std::array<float, 3> mean{};  ///< as the picture has it; what is not finite is left out
  float alpha = 1;              ///< of a transparent picture, whose `mean` is premultiplied
  PixelSums sums{};             ///< of these samples, background included
};

/// `count` distinct numbers below `total`, sorted; all of them if there are not more. Every set of
/// numbers is as likely as any other; the same seed gives the same numbers everywhere.
std::vector<std::uint64_t> choose(std::uint64_t count, std::uint64_t total, std::uint64_t seed);

/// Sets `mean` and `sums` of the pixels, which are distinct and sorted by row, then column. Those
/// of a row are traced together, which is faster than one by one. `scale` is that of the scene.
/// `transparent`: without their background, with alpha (cli/output/picture/transparency.h).
void retrace(const PathTracer& tracer, const RadianceScale& scale, std::span<RetracedPixel> pixels,
             int threads, bool transparent = false);

/// The share of wrong pixels, 0 .. 1, that `count` pixels at random show with a probability of
/// 95 %: one wrong one at least is among them.
double share_found(std::uint64_t count);

}  // namespace parray::verify
