#pragma once

#include <filesystem>
#include <iosfwd>
#include <optional>
#include <string>
#include <vector>

#include "cli/input/color/legend.h"
#include "cli/input/particles/particles.h"
#include "cli/input/scene_file/duplicates.h"
#include "cli/input/scene_file/finish.h"
#include "cli/input/scene_file/label_settings.h"
#include "cli/input/scene_file/material_names.h"
#include "cli/input/scene_file/particle_source.h"
#include "common/scene/scene.h"
#include "common/scene/settings.h"

namespace parray::input {

class PackedFile;

/// A file of particles that has become part of a scene.
struct ParticleFile {
  std::filesystem::path path;  ///< empty: the standard input
  ParticleSource source;       ///< what was asked for of it
  std::uint64_t count = 0;     ///< of particles that the scene shows
  ParticleFacts facts;
};

/// What a scene file says: the scene, and the settings that it asks for. Settings that the file
/// does not name keep the defaults of RenderSettings (which are the seed program's own:
/// 1200 x 800, 500 samples, depth 10).
struct SceneFile {
  Scene scene;
  RenderSettings settings;
  bool transparent = false;  ///< its pictures are to have no background
  bool seed_format = false;  ///< the seed program's format, recognised by its shape
  MaterialNames materials;   ///< the section of that name; the seed's format has none
  /// Files whose particles belong to the scene but are not in it yet: see
  /// cli/input/particles/expand.h.
  std::vector<ParticleSource> particles;
  Finish finish;         ///< what is done to its picture before it is looked at
  LabelSettings labels;  ///< what is to be written on its picture
  // Of its particles, once they are in the scene:
  std::vector<Legend> legends;               ///< what their colours mean
  std::vector<ParticleFile> particle_files;  ///< in order
  std::optional<ParticleCell> cell;          ///< of the first file that has one
  /// So many of the first spheres are what a portrait adds, ground and lights.
  std::uint32_t staging = 0;
  Duplicates duplicates;  ///< spheres of the file that the scene does not have
};

/// Reads scene JSON v1 (scenes/schema/scene.v1.schema.json) or the seed's own format.
///
/// Strict: unknown, missing and duplicate keys, wrong types, numbers out of range and impossible
/// cameras are errors. Spheres in the same place as an earlier one are left out, so that every
/// command, and the scene's identity, has the same scene. Streams: the spheres are never held as
/// JSON. The same for any number of threads. Throws InputError "FILE:LINE: /json/pointer: problem:
/// remedy".
SceneFile read_scene_file(const std::filesystem::path& path, int threads = 1);

/// The same of a file that is open.
SceneFile read_scene_file(PackedFile& file, int threads = 1);

/// The same from an open stream; `name` stands for the file in messages.
SceneFile read_scene(std::istream& input, const std::string& name, int threads = 1);

}  // namespace parray::input
