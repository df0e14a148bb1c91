#pragma once

#include <algorithm>
#include <filesystem>
#include <string>
#include <vector>

#include "cli/input/scene_file/scene_file.h"
#include "common/scene/requirements.h"
#include "common/scene/settings.h"
#include "tests/support/rooms.h"
#include "tests/support/sample_scenes.h"

namespace parray::test {

struct NamedScene {
  std::string name;
  Scene scene;
  RenderSettings settings;  ///< with the choices of `auto`
};

/// Returns the scenes of scenes/ and of scenes/regression/, as pictures of this size.
inline std::vector<NamedScene> all_scene_files(std::uint32_t width, std::uint32_t height,
                                               std::uint32_t samples) {
  std::vector<std::filesystem::path> paths;
  for (const std::string folder : {"/scenes", "/scenes/regression"}) {
    for (const auto& entry : std::filesystem::directory_iterator(PARRAY_SOURCE_DIR + folder)) {
      if (entry.path().extension() == ".json") paths.push_back(entry.path());
    }
  }
  std::sort(paths.begin(), paths.end());
  std::vector<NamedScene> scenes;
  for (const auto& path : paths) {
    const SceneFile file = read_scene_file(path.string());
    RenderSettings settings = file.settings;
    settings.width = width;
    settings.height = height;
    settings.samples_per_pixel = samples;
    scenes.push_back({path.stem().string(), file.scene,
                      resolve_settings(requirements_of(file.scene), settings).settings});
  }
  return scenes;
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
