#pragma once

#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "common/image/image.h"
#include "common/scene/scene.h"

/// Depth cueing: distant surfaces fade into the background. Outlines: lines where a sphere or
/// capsule ends in front of something farther away, as in illustrations. "Sphere" below means both.
namespace parray::postprocess {

/// The visible shapes of a picture, pixel by pixel, from cli/output/channel_tracing.h. Refers to
/// the channels, which must outlive it.
struct SeenSpheres {
  std::span<const float> depth{};         ///< channel "Z"
  std::span<const std::uint32_t> sphere;  ///< channel "sphere"
  /// Number of first spheres that count as background, like the sky: the scenery of an automatic
  /// scene.
  std::uint32_t scenery = 0;
  /// Depth of the farthest surface without the scenery. Pixels with a larger depth show scenery,
  /// too.
  double farthest = std::numeric_limits<double>::infinity();

  /// Returns whether the first sample of a pixel hits the sky or the scenery.
  [[nodiscard]] bool background(std::size_t pixel) const {
    return sphere[pixel] < scenery || sphere[pixel] == UINT32_MAX;
  }
};

/// The share of a surface that fades into the background: 0 at the nearest depth, `strength` at the
/// farthest, linear in depth between.
class DepthFade {
 public:
  /// Nothing fades.
  DepthFade() = default;
  /// Takes the range of depths from the picture, without background. `width`: of the picture, in
  /// pixels. `strength`: see above, in [0, 1]. The depth of a pixel beside background may be a mean
  /// of surface and background. So such pixels count only if there are no others. A pixel in a gap
  /// between surfaces may show a wall far away, too: `seen.farthest` excludes it.
  DepthFade(const SeenSpheres& seen, std::uint32_t width, double strength);
  /// Takes the range of depths from `nearest` to `farthest`.
  DepthFade(double nearest, double farthest, double strength)
      : nearest_(nearest), range_(farthest - nearest), strength_(strength) {}

  /// Returns the share, in [0, 1], at a depth.
  [[nodiscard]] double operator()(double depth) const;

 private:
  double nearest_ = 0;
  double range_ = 0;  ///< 0: nothing fades
  double strength_ = 0;
};

/// Returns the mean colour of pixels that show background and have only such neighbours. No channel
/// exceeds 1. Without such pixels, returns the sky in the viewing direction.
Vec3d background_color(const Image& image, const SeenSpheres& seen, const Scene& scene);

/// Mixes `background` into every pixel that shows a surface and no scenery. With `alpha` (not
/// empty), distant surfaces become transparent instead; `image` is premultiplied by it.
void fade(Image& image, std::vector<float>& alpha, const SeenSpheres& seen, const DepthFade& fade,
          const Vec3d& background);

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
