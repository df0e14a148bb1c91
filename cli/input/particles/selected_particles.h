#pragma once

#include <filesystem>
#include <string>

#include "cli/input/color/particle_colors.h"
#include "cli/input/particles/particles.h"
#include "cli/input/scene_file/particle_source.h"
#include "cli/input/scene_file/scene_file.h"

/// Turns a particle file into spheres: selects particles and appends them to a scene.
namespace parray::input {

/// The particles that a source selects, and their colours if the source has `color_by`.
struct SelectedParticles {
  Particles particles;
  ParticleColors colors;
};

/// Returns what must be read from the file of `source`. A relative name of the topology is relative
/// to `folder`.
ParticleRequest request_of(const ParticleSource& source, const std::filesystem::path& folder,
                           int threads = 1);

/// Reads the open file of `source` and its topology, removes what the filter hides, and colours the
/// rest. Reads only the columns that the source needs.
///
/// Throws the errors of read_particles(). Throws SourceError if the file lacks what a member of the
/// source needs.
SelectedParticles selected_particles(PackedFile& file, const ParticleSource& source,
                                     const std::filesystem::path& folder = {}, int threads = 1);

/// Does the same for the particles of the open file, read as request_of() says.
SelectedParticles selected_particles(Particles particles, PackedFile& file,
                                     const ParticleSource& source,
                                     const std::filesystem::path& folder = {}, int threads = 1);

/// The look of particles if the file supports no automatic rule.
struct DefaultLook {
  std::string material_name;  ///< becomes a material name of the scene if the source uses it
  Material material;
  double radius = 1;
};

/// Decides the rules of `source` for the particles. Appends their spheres to the scene of `file`,
/// the meaning of their colours to its legends, and facts about them to its other members. `path`
/// is the path of the particle file; empty for the standard input. Without `look`, automatic rules
/// that the file does not support are errors. Returns the source with the decided rules.
///
/// Throws SourceError for "material", "radius" and "color_by". Throws the errors of
/// append_spheres().
ParticleSource append_selected(SelectedParticles selected, const std::filesystem::path& path,
                               ParticleSource source, SceneFile& file, int threads,
                               const DefaultLook* look = nullptr);

/// Reads the files of `file.particles` and appends their particles to the scene's spheres, in
/// order. Clears `file.particles`. Names of particle files are relative to the folder of the scene
/// file `scene_path`.
///
/// Throws InputError "SCENE:LINE: /particles/INDEX/...: problem: remedy".
void expand_particles(SceneFile& file, const std::filesystem::path& scene_path, int threads = 1);

}  // namespace parray::input
