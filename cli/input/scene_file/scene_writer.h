#pragma once

#include <functional>
#include <ostream>

#include "cli/input/scene_file/scene_file.h"

namespace parray::input {

/// Writes scene JSON v1 (scenes/schema/scene.v1.schema.json), a sphere on a line. Numbers are the
/// shortest that read back as themselves, so read_scene() of the text gives an equal scene and
/// equal width, height, samples, depth and seed.
///
/// Materials keep the names that `file.materials` has for their values; others are called
/// "material 0" and so on. Files of `file.particles` stay references.
/// Streams; `poll` is called many times a second, and what it throws passes through. The caller
/// looks at the stream's state. Throws InputError for a name of a file that is not UTF-8.
void write_scene(std::ostream& out, const SceneFile& file, const std::function<void()>& poll);

}  // namespace parray::input
