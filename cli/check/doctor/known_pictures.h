#pragma once

#include <cstdint>
#include <vector>

#include "cli/input/scene_file/scene_file.h"
#include "common/image/pixel_sums.h"
#include "common/trace/tracer.h"

/// Scenes whose samples are known exactly. `parray doctor --extremes` and tests/extremes trace
/// them.
namespace parray::doctor {

/// Returns settings of a picture with `samples` per pixel (more than 2^24 count as 2^24) and the
/// max_depth `depth`.
RenderSettings sized(std::uint32_t width, std::uint32_t height, std::uint64_t samples,
                     std::uint32_t depth);

/// Returns an empty scene under a sky of radiance 1, with a pinhole camera.
Scene under_white_sky();

/// Returns a white and a mirror ball that touch, and a glass ball with a bubble. Every sample is 1.
Scene white_balls();

/// Returns a white ball of `radius` around the camera, which is `off_centre` radii from its centre.
/// Every sample is 0, and every path has max_depth segments.
Scene closed_ball(double radius, double off_centre);

/// Returns a grey ball of `radius` that fills the picture. Every sample is 1/2, and every path has
/// two segments: no path meets the surface that it leaves.
Scene grey_ball(double radius);

/// Returns a scene without capsules with all lengths multiplied by 2^k. Its picture has the same
/// bits.
Scene scaled(Scene scene, int k);

/// Returns the number of pixels that differ from `samples` samples of the radiance `fixed` in all
/// channels. `fixed` is in fixed point, 2^32 for the radiance 1.
std::size_t pixels_other_than(const std::vector<PixelSums>& pixels, std::uint64_t fixed,
                              std::uint64_t samples);

}  // namespace parray::doctor
