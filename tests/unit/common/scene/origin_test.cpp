#include "common/scene/origin.h"

#include <doctest/doctest.h>

#include <vector>

#include "common/scene/settings.h"
#include "tests/support/rooms.h"
#include "tests/support/sample_scenes.h"

namespace parray {
namespace {

using test::reference_sha256;
using test::small_scene;
using test::small_settings;

Scene moved(Scene scene, const Vec3d& by) {
  scene.camera.look_from = scene.camera.look_from + by;
  scene.camera.look_at = scene.camera.look_at + by;
  for (Sphere& sphere : scene.spheres) sphere.center = sphere.center + by;
  return scene;
}

}  // namespace

TEST_CASE("a scene around the origin is measured from it, and so is one with a huge ground") {
  CHECK(scene_origin(small_scene()) == Vec3d{});
  CHECK(scene_origin(Scene{}) == Vec3d{});
}

TEST_CASE("a scene far from the origin is measured from its middle, and its giants do not count") {
  const Vec3d far{1 << 20, -(1 << 21), 1 << 20};
  const Scene scene = moved(small_scene(), far);
  const Vec3d origin = scene_origin(scene);
  CHECK(length(origin - far) < 20);
}

TEST_CASE("where a scene lies does not change its picture by more than noise") {
  // By a power of two: no coordinate is rounded, so that the pictures are those of one scene.
  const Scene here = small_scene();
  const Scene there = moved(here, {1 << 20, 0, 0});
  const RenderSettings settings = small_settings(here);
  CHECK(resolve_settings(requirements_of(there), {}).settings->precision == settings.precision);
  const auto mean = [&settings](const Scene& scene) {
    const auto tracer = make_path_tracer(scene, settings);
    std::uint64_t sum = 0;
    for (std::uint32_t y = 0; y < settings.height; ++y) {
      std::vector<PixelSums> row(settings.width);
      TraceCounts counts;
      tracer->trace({y, 0, settings.width}, {0, 64}, row, counts);
      for (const PixelSums& pixel : row) sum += pixel.sum[0] + pixel.sum[1] + pixel.sum[2];
    }
    return static_cast<double>(sum);
  };
  const double ratio = mean(there) / mean(here);
  CHECK(ratio > 0.99);
  CHECK(ratio < 1.01);
}

}  // namespace parray
