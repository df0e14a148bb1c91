#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "common/image/image.h"
#include "common/scene/scene.h"

/// Depth cueing: what is far fades into the background.
namespace parray::postprocess {

/// What is seen of a scene, pixel by pixel, as cli/output/channel_tracing.h has it.
struct SeenSpheres {
  std::span<const float> depth{};         ///< channel "Z"
  std::span<const std::uint32_t> sphere;  ///< channel "sphere"
  /// So many of the first spheres are background, as the sky is: a portrait's floor.
  std::uint32_t staging = 0;

  [[nodiscard]] bool background(std::size_t pixel) const {
    return sphere[pixel] < staging || sphere[pixel] == UINT32_MAX;
  }
};

/// How much of a surface is lost to the background: 0 where the nearest is seen, `strength` where
/// the farthest is, in proportion to depth between.
class DepthFade {
 public:
  DepthFade() = default;
  /// From the picture's own depths, those of background left out. Of a pixel beside background the
  /// depth is a mean with that, so others decide where there are any.
  DepthFade(const SeenSpheres& seen, std::uint32_t width, double strength);

  [[nodiscard]] double operator()(double depth) const;

 private:
  double nearest_ = 0;
  double range_ = 0;  ///< 0: nothing fades
  double strength_ = 0;
};

/// The mean colour of the pixels that show background and are in the midst of others that do, no
/// channel above 1; where there is none, the sky in the direction in which the camera looks.
Vec3d background_color(const Image& image, const SeenSpheres& seen, const Scene& scene);

/// Mixes `background` into every pixel that shows more than background. With `alpha`, not empty,
/// what is far becomes transparent instead; `image` is premultiplied by it.
void fade(Image& image, std::vector<float>& alpha, const SeenSpheres& seen, const DepthFade& fade,
          const Vec3d& background);

}  // namespace parray::postprocess
