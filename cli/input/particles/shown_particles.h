#pragma once

#include <filesystem>

#include "cli/input/color/particle_paint.h"
#include "cli/input/particles/particles.h"
#include "cli/input/scene_file/particle_source.h"
#include "cli/input/scene_file/scene_file.h"

namespace parray::input {

/// The particles of a file that are shown, and their colours where `color_by` asks for some.
struct ShownParticles {
  Particles particles;
  ParticlePaint paint;
};

/// What has to be read of the file of `source`, whose topology is in `folder` unless its name is
/// absolute.
ParticleRequest request_of(const ParticleSource& source, const std::filesystem::path& folder,
                           int threads = 1);

/// Reads the file of `source`, which is open, its topology in `folder` unless that is
/// absolute, leaves out what its filter does not show, and colours the rest. What a source does not
/// ask for is not read.
///
/// Throws InputError as read_particles() does, and SourceError for what a member of the source asks
/// for.
ShownParticles shown_particles(PackedFile& file, const ParticleSource& source,
                               const std::filesystem::path& folder = {}, int threads = 1);

/// The rule that `source.material` comes to: see particle_spheres.h, but for particles that
/// `color_by` paints. Throws SourceError where both say what the colour is.
ParticleMaterial decided_material(const ParticleSource& source, const Particles& particles);

/// Appends the particles' spheres to the file's scene, what their colours mean to its legends, and
/// what else is known of them; `path` is the file's, empty for the standard input.
/// The rules of `source` are decided and without problem. Throws as append_spheres() does.
void append_shown(ShownParticles shown, const std::filesystem::path& path,
                  const ParticleSource& source, SceneFile& file, int threads = 1);

}  // namespace parray::input
