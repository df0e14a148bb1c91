#pragma once

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "cli/input/scene_file/scene_file.h"
#include "common/scene/requirements.h"
#include "common/scene/settings.h"
#include "tests/support/rooms.h"

namespace parray::test {

struct NamedScene {
  std::string name;
  Scene scene;
  RenderSettings settings;  ///< with the choices of `auto`
};

/// Returns the scenes in `folder` (scenes/ of the sources) and in its folder regression, as
/// pictures of this size.
inline std::vector<NamedScene> scene_files(const std::filesystem::path& folder, std::uint32_t width,
                                           std::uint32_t height, std::uint32_t samples) {
  std::vector<std::filesystem::path> paths;
  for (const auto& place : {folder, folder / "regression"}) {
    for (const auto& entry : std::filesystem::directory_iterator(place)) {
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

}  // namespace parray::test
