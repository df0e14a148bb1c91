#include "cli/output/postprocess/depth_cue.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "cli/input/color/number_bounds.h"

namespace parray::postprocess {
namespace {

/// Returns whether the test is true for a pixel and its left, right, upper and lower neighbours.
bool all_around(std::size_t pixel, std::size_t width, std::size_t count, const auto& test) {
  return test(pixel) && (pixel % width == 0 || test(pixel - 1)) &&
         (pixel % width == width - 1 || test(pixel + 1)) &&
         (pixel < width || test(pixel - width)) && (pixel + width >= count || test(pixel + width));
}

}  // namespace

DepthFade::DepthFade(const SeenSpheres& seen, std::uint32_t width, double strength)
    : strength_(strength) {
  const auto in_front = [&](std::size_t pixel) { return !seen.background(pixel); };
  const std::size_t count = seen.sphere.size();
  NumberBounds inner;
  NumberBounds all;
  for (std::size_t i = 0; i < count; ++i) {
    if (!in_front(i) || !std::isfinite(seen.depth[i]) || seen.depth[i] > seen.farthest) continue;
    all.add(seen.depth[i]);
    if (all_around(i, width, count, in_front)) inner.add(seen.depth[i]);
  }
  const NumberBounds& range = inner.empty() ? all : inner;
  if (range.empty()) return;
  nearest_ = range.low;
  range_ = range.high - range.low;
}

double DepthFade::operator()(double depth) const {
  return range_ > 0 ? strength_ * std::clamp((depth - nearest_) / range_, 0.0, 1.0) : 0;
}

Vec3d background_color(const Image& image, const SeenSpheres& seen, const Scene& scene) {
  const auto background = [&](std::size_t pixel) { return seen.background(pixel); };
  const std::size_t count = seen.sphere.size();
  std::array<double, 3> sum{};
  std::size_t pixels = 0;
  for (std::size_t i = 0; i < count; ++i) {
    if (!all_around(i, image.width, count, background)) continue;
    ++pixels;
    for (std::size_t c = 0; c < 3; ++c) sum[c] += std::min(image.rgb[3 * i + c], 1.0F);
  }
  const Camera& camera = scene.camera;
  const double up = normalize(camera.look_at - camera.look_from).y;
  const Vec3d sky = scene.sky.horizon + ((up + 1) / 2) * (scene.sky.zenith - scene.sky.horizon);
  if (pixels == 0) return {std::min(sky.x, 1.0), std::min(sky.y, 1.0), std::min(sky.z, 1.0)};
  const double share = 1 / static_cast<double>(pixels);
  return share * Vec3d{sum[0], sum[1], sum[2]};
}

void fade(Image& image, std::vector<float>& alpha, const SeenSpheres& seen, const DepthFade& fade,
          const Vec3d& background) {
  const std::array<double, 3> far{background.x, background.y, background.z};
  for (std::size_t i = 0; i < seen.sphere.size(); ++i) {
    const bool staged = seen.sphere[i] < seen.scenery;
    if (staged || !std::isfinite(seen.depth[i])) continue;
    const double lost = fade(seen.depth[i]);
    for (std::size_t c = 0; c < 3; ++c) {
      float& value = image.rgb[3 * i + c];
      value = static_cast<float>((1 - lost) * value + (alpha.empty() ? lost * far[c] : 0));
    }
    if (!alpha.empty()) alpha[i] = static_cast<float>((1 - lost) * alpha[i]);
  }
}

}  // namespace parray::postprocess
