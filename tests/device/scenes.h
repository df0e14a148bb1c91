#pragma once

#include <cstdint>
#include <vector>

#include "tests/support/rooms.h"
#include "tests/support/sample_scenes.h"
#include "tests/support/scene_files.h"

namespace parray::test {

/// Returns the scenes of scenes/ and of scenes/regression/, as pictures of this size.
inline std::vector<NamedScene> all_scene_files(std::uint32_t width, std::uint32_t height,
                                               std::uint32_t samples) {
  return scene_files(PARRAY_SOURCE_DIR "/scenes", width, height, samples);
}

/// Returns overlapping balls and sticks of glass, metal and paint: paths cross surfaces inside of
/// glass, and bodies nest.
inline Scene overlapping_shapes() {
  Scene scene = small_scene();
  for (std::uint32_t i = 0; i < 60; ++i) {
    const Vec3d center{0.4 * (i % 6) - 1, 0.3 + 0.2 * (i % 7), 0.4 * (i / 10) - 1};
    scene.spheres.push_back({center, 0.3, i % 4});
    scene.capsules.push_back({center, center + Vec3d{0.1 * (i % 3), 0.4, 0.3}, 0.15, (i + 2) % 4});
  }
  return scene;
}

/// Returns `count` balls of glass, one inside the other, around the eye or in front of it.
inline Scene nested_balls(std::uint32_t count, bool around_eye) {
  Scene scene = small_scene();
  scene.spheres.clear();
  for (std::uint32_t i = 0; i < count; ++i) {
    const auto material = static_cast<std::uint32_t>(scene.materials.size());
    scene.materials.push_back({MaterialType::dielectric, {1, 1, 1}, 0, 1.0 + 0.03 * (i + 1)});
    const double radius = 1 + 0.1 * i;
    scene.spheres.push_back(
        {around_eye ? scene.camera.look_from : Vec3d{0, 0, 0}, radius, material});
  }
  scene.spheres.push_back({{0, -1001, 0}, 1000, 0});
  return scene;
}

}  // namespace parray::test
