#pragma once

#include <vector>

#include "cli/output/postprocess/depth_cue.h"
#include "common/image/image.h"
#include "common/scene/scene.h"

/// Lines where spheres end before something that is farther away, as illustrators draw them.
namespace parray::postprocess {

/// Almost black, linear RGB.
inline constexpr Vec3d outline_ink{0.01, 0.01, 0.01};

/// The share of each pixel, in [0, 1], that lines `width` pixels wide (> 0) cover.
///
/// Which spheres are seen where is told by channel "sphere"; where their silhouettes are, by the
/// scene and its camera, a pinhole: so lines are smooth whatever the channel's pixels are. A line
/// is drawn along the silhouette of a sphere where the background, or another sphere, is seen
/// beside it, the stronger the farther behind: not at all where two spheres cross, fully from a
/// third of the radius on. Spheres that are not seen wider than the line have none.
///
/// Where `fade` takes a surface to the background, it takes the lines, too. The same for any number
/// of `threads`.
std::vector<float> outline_of(const Scene& scene, std::uint32_t width, std::uint32_t height,
                              const SeenSpheres& seen, double line_width,
                              const DepthFade& fade = {}, int threads = 1);

/// Draws `ink` over the shares of the pixels that it covers; with `alpha`, not empty, lines are
/// opaque on what may be transparent, and `image` is premultiplied by it.
void draw_ink(Image& image, std::vector<float>& alpha, const std::vector<float>& shares,
              const Vec3d& ink = outline_ink);

}  // namespace parray::postprocess
