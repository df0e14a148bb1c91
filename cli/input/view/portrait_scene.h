#pragma once

#include <filesystem>

#include "cli/input/particles/particles.h"
#include "cli/input/scene_file/scene_file.h"
#include "cli/input/view/portrait.h"

namespace parray::input {

/// Settings of a portrait unless options say otherwise: 1200 x 900, 256 samples, depth 10.
RenderSettings portrait_settings();

/// Name, in a portrait's scene, of the one material for all particles.
inline constexpr std::string_view portrait_plain_name = "plain";

/// A particle file as a scene of its own.
struct PortraitScene {
  SceneFile file;         ///< `staging` props, then the particles, as spheres
  ParticleSource source;  ///< what made them, its rules decided; `file` is as given
};

/// Reads a particle file and takes its portrait (see portrait.h) for `settings`, whose width and
/// height the view is framed for. `source` says what is shown of it; its own `file` does not count.
/// `automatic` ends, where the file has nothing better, in the plain material and in
/// lattice_radius(); the only known name of a material is portrait_plain_name.
/// Molecules, for the automatic view, are files with elements that have no cell, or names of
/// residues and a cell that they do not fill.
///
/// Throws InputError "FILE: problem: remedy".
PortraitScene portrait_scene(const std::filesystem::path& path, ParticleSource source,
                             const RenderSettings& settings, const Viewing& viewing = {},
                             int threads = 1);

/// The same of a file that is open.
PortraitScene portrait_scene(PackedFile& file, ParticleSource source,
                             const RenderSettings& settings, const Viewing& viewing = {},
                             int threads = 1);

/// The same scene with its particles in the file again: `file` is its name for the scene file.
SceneFile with_reference(PortraitScene portrait, const std::string& file);

}  // namespace parray::input
