#pragma once

#include <filesystem>

#include "cli/input/scene_file/scene_file.h"

namespace parray::input {

/// Reads the files of `file.particles` and appends their particles to the scene's spheres, in
/// order; `file.particles` is empty afterwards. `scene_path` is that of the scene file: the
/// particle files' names are relative to its folder.
///
/// Throws InputError "SCENE:LINE: /particles/INDEX/...: problem: remedy".
void expand_particles(SceneFile& file, const std::filesystem::path& scene_path, int threads = 1);

}  // namespace parray::input
