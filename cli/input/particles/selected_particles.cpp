#include "cli/input/particles/selected_particles.h"

#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "cli/input/particles/file_place.h"
#include "cli/input/particles/packed_file.h"
#include "cli/input/particles/particle_spheres.h"
#include "cli/input/scene_file/json_value.h"
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
  if (source.look.coloring.empty()) return decided(source.look.material, particles);
  const Rule rule = source.look.material.rule;
  if (rule != Rule::automatic && rule != Rule::named && rule != Rule::color_by) {
    throw SourceError("color_by",
                      "material is " + text_of(source.look.material) +
                          ", which also sets the colour: leave out material or color_by");
  }
  return {Rule::color_by, source.look.material.name};
}

/// Decides the rules of `source`. Afterwards the particles support these rules.
void decide(const Particles& particles, const DefaultLook* look, MaterialNames& materials,
            ParticleSource& source) {
  const auto check = [](const char* key, const std::string& problem) {
    if (!problem.empty()) throw SourceError(key, problem);
  };
  source.look.material = decided_material(source, particles);
  source.look.radius = decided(source.look.radius, particles, source.cell.crystal.value_or(false));
  std::string_view otherwise = "the name of a material";
  if (look != nullptr) {
    otherwise = look->material_name;
    if (source.look.material.rule == Rule::automatic)
      source.look.material = {Rule::named, look->material_name};
    if (text_of(source.look.material) == look->material_name) {
      materials.define(look->material_name, look->material);
    }
    if (source.look.radius.rule == ParticleRadius::Rule::automatic) {
      source.look.radius = {ParticleRadius::Rule::fixed, look->radius};
    }
  }
  check("material",
        problem_with(source.look.material, particles, materials, source.file, otherwise));
  check("radius", problem_with(source.look.radius, particles, source.file));
}

/// Expands one source. Errors name the place in the scene file that refers to the particle file,
/// then the problem in the particle file.
void expand(ParticleSource source, const JsonPlace& place, const std::filesystem::path& folder,
            SceneFile& file, int threads) {
  source.cell.crystal = source.cell.crystal.value_or(false);
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
  request.numbers.merge(numbers_of(source.look.coloring));
  request.numbers.merge(numbers_of(source.cell));
  return request;
}

SelectedParticles selected_particles(PackedFile& file, const ParticleSource& source,
                                     const std::filesystem::path& folder, int threads) {
  const ParticleRequest request = request_of(source, folder, threads);
  SelectedParticles selected{read_particles(file, request), {}};
  CellOperations operations = source.cell;
  operations.crystal = operations.crystal.value_or(is_crystal(selected.particles));
  selected.crystal = *operations.crystal;
  with_remedy("center", {}, file, request, [&] { apply(operations, selected.particles, threads); });
  with_remedy("select", {}, file, request,
              [&] { apply(source.filter, selected.particles, threads); });
  if (source.look.coloring.empty()) return selected;
  with_remedy("color_by", color_by_words, file, request, [&] {
    selected.colors = colors_of(source.look.coloring, selected.particles, threads);
  });
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
                               ? legend_of(selected.particles, source.look.material, file.materials)
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
