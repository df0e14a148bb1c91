#pragma once

#include <string>

#include "cli/commands/options.h"
#include "common/input/scene_file.h"

namespace parray {

/// The scene in a scene file, its particles among its spheres, or the portrait of a particle file;
/// with the options laid over its settings. Warns of duplicates on stderr. Throws InputError.
SceneFile load_scene(const std::string& file, const RenderOptions& options);

}  // namespace parray
