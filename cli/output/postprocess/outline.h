#pragma once

#include <vector>

#include "cli/output/postprocess/depth_cue.h"
#include "common/image/image.h"
#include "common/scene/scene.h"

/// Outlines: lines where a sphere or capsule ends in front of something farther away, as in
/// illustrations. "Sphere" below means both.
namespace parray::postprocess {

/// Almost black, linear RGB.
inline constexpr Vec3d outline_ink{0.01, 0.01, 0.01};

/// Returns the share of each pixel, in [0, 1], that lines of `line_width` pixels (> 0) cover.
///
/// The picture has `width` x `height` pixels. Channel "sphere" tells which spheres are visible.
/// Silhouettes follow from the scene and its pinhole camera, so that lines are smooth at any
/// resolution. A line follows the silhouette of a sphere where the background or another sphere is
/// visible beside it. It gets stronger with the distance behind the sphere: invisible where two
/// spheres intersect, full from 0.3 of the radius on. Spheres narrower than the line have no line.
///
/// Lines fade with their surface (`fade`). The scene's camera must have aperture 0. The result is
/// the same for any number of `threads`.
std::vector<float> outline_of(const Scene& scene, std::uint32_t width, std::uint32_t height,
                              const SeenSpheres& seen, double line_width,
                              const DepthFade& fade = {}, int threads = 1);

/// Draws `ink` on the covered shares of the pixels. With `alpha` (not empty), lines are opaque;
/// `image` is premultiplied by it.
void draw_ink(Image& image, std::vector<float>& alpha, const std::vector<float>& shares,
              const Vec3d& ink = outline_ink);

}  // namespace parray::postprocess
