#include "cli/input/particles/expand.h"

#include <string>
#include <utility>

#include "cli/input/particles/packed_file.h"
#include "cli/input/particles/particle_spheres.h"
#include "cli/input/particles/shown_particles.h"
#include "cli/input/particles/source_error.h"
#include "common/base/error.h"

namespace parray::input {
namespace {

/// Appends the particles of `source`; throws as the functions that it calls do.
void append(ParticleSource source, const std::filesystem::path& folder, SceneFile& file,
            int threads) {
  PackedFile particles(folder / source.file);
  ShownParticles shown = shown_particles(particles, source, folder, threads);
  const auto check = [](const char* key, const std::string& problem) {
    if (!problem.empty()) throw SourceError(key, problem);
  };
  source.material = decided_material(source, shown.particles);
  check("material", problem_with(source.material, shown.particles, file.materials, source.file));
  source.radius = decided(source.radius, shown.particles);
  check("radius", problem_with(source.radius, shown.particles, source.file));
  append_shown(std::move(shown), particles.path(), source, file, threads);
}

/// The particle file's message says where in it; the scene's place says who asked for what.
void expand(const ParticleSource& source, const JsonPlace& place,
            const std::filesystem::path& folder, SceneFile& file, int threads) {
  try {
    append(source, folder, file, threads);
  } catch (const SourceError& error) {
    place.at(error.key()).fail(source.line_of(error.key()), error.what());
  } catch (const InputError& error) {
    place.at("file").fail(source.file_line, error.what());
  }
}

}  // namespace

void expand_particles(SceneFile& file, const std::filesystem::path& scene_path, int threads) {
  const std::string name = scene_path.string();
  const JsonPlace root(name);
  const JsonPlace section = root.at("particles");
  for (std::size_t i = 0; i < file.particles.size(); ++i) {
    expand(file.particles[i], section.at(i), scene_path.parent_path(), file, threads);
  }
  file.particles.clear();
}

}  // namespace parray::input
