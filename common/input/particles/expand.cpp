#include "common/input/particles/expand.h"

#include <string>
#include <utility>

#include "common/base/error.h"
#include "common/input/particles/particle_spheres.h"

namespace parray {
namespace {

/// The particle file's message says where in it; the scene's place says who named it.
template <typename Work>
auto with_context(const ParticleSource& source, const JsonPlace& place, const Work& work) {
  try {
    return work();
  } catch (const InputError& error) {
    place.at("file").fail(source.file_line, error.what());
  }
}

void expand(ParticleSource source, const JsonPlace& place, const std::filesystem::path& folder,
            SceneFile& file, int threads) {
  Particles particles = with_context(source, place, [&] {
    return read_particles(folder / source.file, {.frame = source.frame, .threads = threads});
  });
  source.material = decided(source.material, particles);
  source.radius = decided(source.radius, particles);
  std::string problem = problem_with(source.material, particles, file.materials, source.file);
  if (!problem.empty()) place.at("material").fail(source.material_line, problem);
  problem = problem_with(source.radius, particles, source.file);
  if (!problem.empty()) place.at("radius").fail(source.radius_line, problem);
  note_particles(file, particles);
  add_legend(file.legends, legend_of(particles, source.material, file.materials));
  with_context(source, place, [&] {
    append_spheres(std::move(particles), source, file.materials, file.scene, threads);
  });
}

}  // namespace

void note_particles(SceneFile& file, const Particles& particles) {
  file.facts.push_back(particles.facts);
  if (!file.cell) file.cell = particles.cell;
}

void expand_particles(SceneFile& file, const std::filesystem::path& scene_path, int threads) {
  const std::string name = scene_path.string();
  const JsonPlace root(name);
  const JsonPlace section = root.at("particles");
  for (std::size_t i = 0; i < file.particles.size(); ++i) {
    expand(file.particles[i], section.at(i), scene_path.parent_path(), file, threads);
  }
  file.particles.clear();
}

}  // namespace parray
