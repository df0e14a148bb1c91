#pragma once

#include <filesystem>

#include "cli/input/particles/particles.h"
#include "cli/input/scene_file/scene_file.h"
#include "cli/input/view/surroundings.h"
#include "common/scene/settings_fwd.h"

namespace parray::input {

/// Returns the default settings of an auto scene: 1200 x 900, 256 samples, depth 10.
Boxed<RenderSettings> auto_scene_settings();

/// Name of the one material for all particles in an auto scene.
inline constexpr std::string_view plain_material_name = "plain";

/// A particle file as a scene of its own.
struct AutoScene {
  SceneFile file;         ///< spheres of the scenery, then those of the particles
  ParticleSource source;  ///< made them; its rules are decided, `file` is as given
};

/// Makes a scene of a particle file: its spheres and the surroundings for `settings`, whose width
/// and height give the shape of the picture. `source` says what is shown; its `file` is ignored.
/// `automatic` rules fall back to the plain material and to lattice_radius(). The only known name
/// of a material is plain_material_name. The automatic view takes particles for a molecule if they
/// have elements and no cell, or residue names and a cell that they do not fill.
///
/// Throws InputError "FILE: problem: remedy".
AutoScene auto_scene(const std::filesystem::path& path, ParticleSource source,
                     const RenderSettings& settings, const Viewing& viewing = {}, int threads = 1);

/// The same for an open file.
AutoScene auto_scene(PackedFile& file, ParticleSource source, const RenderSettings& settings,
                     const Viewing& viewing = {}, int threads = 1);

/// Returns the scene with its particles in their file again. `file` is the name for the scene file.
SceneFile with_reference(AutoScene scene, const std::string& file);

}  // namespace parray::input
