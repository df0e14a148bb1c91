#pragma once

#include <filesystem>
#include <string>

#include "cli/input/color/particle_colors.h"
#include "cli/input/particles/particles.h"
#include "cli/input/scene_file/particle_source.h"
#include "cli/input/scene_file/scene_file.h"

/// From a particle file to spheres: what a source selects, and how it becomes part of a scene.
namespace parray::input {

/// The particles of a file that a source selects, and their colours if `color_by` asks for some.
struct SelectedParticles {
  Particles particles;
  ParticleColors colors;
};

/// Returns what has to be read of the file of `source`. A relative name of the topology is relative
/// to `folder`.
ParticleRequest request_of(const ParticleSource& source, const std::filesystem::path& folder,
                           int threads = 1);

/// Reads the open file of `source` and its topology, removes what the filter does not show, and
/// colours the rest. Reads only the columns that the source needs.
///
/// Throws InputError as read_particles() does, and SourceError if the file lacks what a member of
/// the source asks for.
SelectedParticles selected_particles(PackedFile& file, const ParticleSource& source,
                                     const std::filesystem::path& folder = {}, int threads = 1);

/// What `automatic` stands for if the file supports none of the rules.
struct DefaultLook {
  std::string material_name;  ///< becomes a name of the scene if the source uses it
  Material material;
  double radius = 1;
};

/// Decides the rules of `source` for the particles and appends their spheres to the scene of
/// `file`, the meaning of their colours to its legends, and what else is known of them. `path` is
/// that of the particle file; empty for the standard input. Without `look`, automatic rules that
/// the file does not support are errors. Returns the source with the decided rules.
///
/// Throws SourceError for "material", "radius" and "color_by", and InputError as append_spheres()
/// does.
ParticleSource append_selected(SelectedParticles selected, const std::filesystem::path& path,
                               ParticleSource source, SceneFile& file, int threads,
                               const DefaultLook* look = nullptr);

/// Reads the files of `file.particles` and appends their particles to the scene's spheres, in
/// order; `file.particles` is empty afterwards. Names of particle files are relative to the folder
/// of `scene_path`, the scene file.
///
/// Throws InputError "SCENE:LINE: /particles/INDEX/...: problem: remedy".
void expand_particles(SceneFile& file, const std::filesystem::path& scene_path, int threads = 1);

}  // namespace parray::input
