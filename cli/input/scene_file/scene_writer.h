#pragma once

#include <functional>
#include <ostream>

#include "cli/input/scene_file/scene_file.h"

namespace parray::input {

/// Writes scene JSON v1 (scenes/schema/scene.v1.schema.json), one shape per line. Writes numbers in
/// the shortest form that reads back as the same number. So read_scene() of the text gives an equal
/// scene (if the scene has no duplicate spheres) and equal width, height, samples, depth and seed.
///
/// Materials keep the names of `file.materials`. Other materials are called "material 0" and so on.
/// Files of `file.particles` stay references.
///
/// Calls `poll` many times a second and passes on its exceptions, so that the caller can stop the
/// writer. The caller must check the state of the stream. Throws InputError for a name or a text
/// that is not UTF-8.
void write_scene(std::ostream& out, const SceneFile& file, const std::function<void()>& poll);

}  // namespace parray::input
