#pragma once

#include <filesystem>
#include <vector>

#include "cli/input/particles/particles.h"
#include "cli/input/scene_file/scene_file.h"
#include "cli/input/view/surroundings.h"
#include "common/scene/settings_fwd.h"

namespace parray::input {

/// Returns the eight corners of the cell.
std::vector<Vec3d> corners_of(const ParticleCell& cell);

/// Returns the default settings of an automatic scene: 1200 x 900, 256 samples, depth 10.
Boxed<RenderSettings> auto_scene_settings();

/// The error of a picture of an automatic scene, in linear radiance. It replaces the number of
/// samples wherever a picture may stop at an error.
inline constexpr double auto_scene_error = 0.02;

/// Name of the only material of particles in an automatic scene.
inline constexpr std::string_view plain_material_name = "plain";

/// A scene that was made from a particle file.
struct AutoScene {
  SceneFile file;         ///< spheres of the scenery, then those of the particles; capsules
  ParticleSource source;  ///< source of these particles; its rules are decided, `file` is as given
  TurnAxis axis;          ///< of a turntable; see Surroundings
};

/// Makes a scene from a particle file: spheres and surroundings. The width and height of `settings`
/// give the shape of the picture. `source` determines what is shown; its `file` is ignored.
/// `automatic` rules fall back to the plain material and to lattice_radius(). The only known
/// material name is plain_material_name. The automatic view treats particles as a molecule if they
/// have elements and either no cell, or residue names and a cell that they do not fill. Pictures of
/// crystals, which is_crystal() recognises if `source` does not tell, have the label `cell`. Small
/// molecules are drawn as balls and sticks: see decide_style().
///
/// Throws InputError "FILE: problem: remedy".
AutoScene auto_scene(const std::filesystem::path& path, const ParticleSource& source,
                     const RenderSettings& settings, const Viewing& viewing = {}, int threads = 1);

/// Does the same for an open file.
AutoScene auto_scene(PackedFile& file, const ParticleSource& source, const RenderSettings& settings,
                     const Viewing& viewing = {}, int threads = 1);

/// Returns a scene that refers to the particle file `file` instead of containing its shapes.
SceneFile with_reference(AutoScene scene, const std::string& file);

}  // namespace parray::input
