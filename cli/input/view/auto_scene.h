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

/// Returns the default settings of an automatic scene: 1200 x 900 pixels, 256 samples per pixel,
/// paths of at most 10 segments.
Boxed<RenderSettings> auto_scene_settings();

/// The default of RenderSettings::target_error for automatic scenes, in linear radiance. Commands
/// that may stop a picture at an error use it instead of the number of samples.
inline constexpr double auto_scene_error = 0.02;

/// Name of plain_material (surroundings.h) in automatic scenes.
inline constexpr std::string_view plain_material_name = "plain";

/// A scene that was made from a particle file.
struct AutoScene {
  SceneFile file;         ///< spheres of the scenery, then those of the particles; capsules
  ParticleSource source;  ///< of the particles, with the rules that were used for automatic
                          ///< ones; `file` is PackedFile::name()
  TurnAxis axis;          ///< of a turntable; see Surroundings
};

/// Makes a scene from a particle file: spheres and surroundings. The width and height of `settings`
/// give the shape of the picture. `source` determines what is shown; its `file` is ignored. If
/// neither `source` nor the file determines a look, particles have the plain material and the
/// radius lattice_radius(), or half of it as balls between sticks. `source` may name the material
/// plain_material_name. The automatic view treats particles as a molecule if they have elements and
/// either no cell, or residue names and a cell that they do not fill. They fill a cell if they
/// extend over three quarters of each edge. Pictures of crystals, which is_crystal() recognises if
/// `source` does not tell, have the label `cell`, unless it leaves the particles too little room
/// and Viewing::whole_cell is false. Small molecules are drawn as balls and sticks: see
/// decide_style() in sticks.h.
///
/// Throws InputError "FILE: problem: remedy", for labels a LabelError.
AutoScene auto_scene(const std::filesystem::path& path, const ParticleSource& source,
                     const RenderSettings& settings, const Viewing& viewing = {}, int threads = 1);

/// Does the same for an open file.
AutoScene auto_scene(PackedFile& file, const ParticleSource& source, const RenderSettings& settings,
                     const Viewing& viewing = {}, int threads = 1);

/// Returns a scene that refers to the particle file `file` instead of containing its shapes. The
/// scene keeps the scenery. `file` is a path as in ParticleSource::file.
SceneFile with_reference(AutoScene scene, const std::string& file);

}  // namespace parray::input
