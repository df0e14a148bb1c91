#include "cli/input/particles/selected_particles.h"

#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "cli/input/particles/file_place.h"
#include "cli/input/particles/packed_file.h"
#include "cli/input/particles/particle_spheres.h"
#include "cli/input/select/columns.h"
#include "cli/input/select/selection.h"
#include "common/base/error.h"

namespace parray::input {
namespace {

using Rule = ParticleMaterial::Rule;

/// Runs `work`. If it needs an unknown number, throws an error that lists the valid names: the
/// `words` that `key` accepts and the numbers of the file.
template <typename Work>
void with_remedy(const char* key, std::span<const std::string_view> words, PackedFile& file,
                 ParticleRequest request, const Work& work) {
  try {
    work();
  } catch (const UnknownNumber& error) {
    request.all = true;
    std::vector<std::string> known(words.begin(), words.end());
    const auto numbers = number_names(read_particles(file, request));
    known.insert(known.end(), numbers.begin(), numbers.end());
    throw SourceError(key, error.with_remedy(known));
  }
}

/// Returns the decided rule of the material of `source`.
ParticleMaterial decided_material(const ParticleSource& source, const Particles& particles) {
  if (source.coloring.empty()) return decided(source.material, particles);
  const Rule rule = source.material.rule;
  if (rule != Rule::automatic && rule != Rule::named && rule != Rule::color_by) {
    throw SourceError("color_by",
                      "material is " + text_of(source.material) +
                          ", which also sets the colour: leave out material or color_by");
  }
  return {Rule::color_by, source.material.name};
}

/// Decides the rules of `source`. Afterwards the particles support these rules.
void decide(const Particles& particles, const DefaultLook* look, MaterialNames& materials,
            ParticleSource& source) {
  const auto check = [](const char* key, const std::string& problem) {
    if (!problem.empty()) throw SourceError(key, problem);
  };
  source.material = decided_material(source, particles);
  source.radius = decided(source.radius, particles);
  std::string_view otherwise = "the name of a material";
  if (look != nullptr) {
    otherwise = look->material_name;
    if (source.material.rule == Rule::automatic)
      source.material = {Rule::named, look->material_name};
    if (text_of(source.material) == look->material_name) {
      materials.define(look->material_name, look->material);
    }
    if (source.radius.rule == ParticleRadius::Rule::automatic) {
      source.radius = {ParticleRadius::Rule::fixed, look->radius};
    }
  }
  check("material", problem_with(source.material, particles, materials, source.file, otherwise));
  check("radius", problem_with(source.radius, particles, source.file));
}

/// Expands one source. Errors name the place in the scene file that refers to the particle file,
/// then the problem in the particle file.
void expand(const ParticleSource& source, const JsonPlace& place,
            const std::filesystem::path& folder, SceneFile& file, int threads) {
  try {
    PackedFile particles(folder / source.file);
    append_selected(selected_particles(particles, source, folder, threads), particles.path(),
                    source, file, threads);
  } catch (const SourceError& error) {
    place.at(error.key()).fail(source.line_of(error.key()), error.what());
  } catch (const InputError& error) {
    place.at("file").fail(source.file_line, error.what());
  }
}

}  // namespace

ParticleRequest request_of(const ParticleSource& source, const std::filesystem::path& folder,
                           int threads) {
  ParticleRequest request{
      .frame = source.frame, .alternatives = source.alternatives, .threads = threads};
  if (!source.topology.empty()) request.topology = folder / source.topology;
  request.numbers = numbers_of(source.filter);
  request.numbers.merge(numbers_of(source.coloring));
  return request;
}

SelectedParticles selected_particles(PackedFile& file, const ParticleSource& source,
                                     const std::filesystem::path& folder, int threads) {
  const ParticleRequest request = request_of(source, folder, threads);
  return selected_particles(read_particles(file, request), file, source, folder, threads);
}

SelectedParticles selected_particles(Particles particles, PackedFile& file,
                                     const ParticleSource& source,
                                     const std::filesystem::path& folder, int threads) {
  const ParticleRequest request = request_of(source, folder, threads);
  SelectedParticles selected{std::move(particles), {}};
  with_remedy("select", {}, file, request,
              [&] { apply(source.filter, selected.particles, threads); });
  if (source.coloring.empty()) return selected;
  with_remedy("color_by", color_by_words, file, request,
              [&] { selected.colors = colors_of(source.coloring, selected.particles, threads); });
  return selected;
}

ParticleSource append_selected(SelectedParticles selected, const std::filesystem::path& path,
                               ParticleSource source, SceneFile& file, int threads,
                               const DefaultLook* look) {
  decide(selected.particles, look, file.materials, source);
  file.particle_files.push_back(
      {path, source, selected.particles.count(), selected.particles.facts});
  if (!file.cell) file.cell = selected.particles.cell;
  add_legend(file.legends, selected.colors.empty()
                               ? legend_of(selected.particles, source.material, file.materials)
                               : std::move(selected.colors.legend));
  append_spheres(std::move(selected.particles), selected.colors, source, file.materials, file.scene,
                 threads);
  return source;
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

}  // namespace parray::input
