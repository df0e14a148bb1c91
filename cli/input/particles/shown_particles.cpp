#include "cli/input/particles/shown_particles.h"

#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "cli/input/particles/particle_spheres.h"
#include "cli/input/particles/source_error.h"
#include "cli/input/select/number_source.h"
#include "cli/input/select/selection.h"
#include "common/base/error.h"

namespace parray::input {

ParticleRequest request_of(const ParticleSource& source, const std::filesystem::path& folder,
                           int threads) {
  ParticleRequest request{
      .frame = source.frame, .alternatives = source.alternatives, .threads = threads};
  if (!source.topology.empty()) request.topology = folder / source.topology;
  request.numbers = numbers_of(source.filter);
  request.numbers.merge(numbers_of(source.coloring));
  return request;
}

namespace {

using Rule = ParticleMaterial::Rule;

/// Does `work`; where it asks for a number that is not there, the error names those that are, after
/// the `words` that `key` takes besides.
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

}  // namespace

ShownParticles shown_particles(PackedFile& file, const ParticleSource& source,
                               const std::filesystem::path& folder, int threads) {
  const ParticleRequest request = request_of(source, folder, threads);
  ShownParticles shown{read_particles(file, request), {}};
  with_remedy("select", {}, file, request, [&] { apply(source.filter, shown.particles, threads); });
  if (source.coloring.empty()) return shown;
  with_remedy("color_by", color_by_words, file, request,
              [&] { shown.paint = painted(source.coloring, shown.particles, threads); });
  return shown;
}

ParticleMaterial decided_material(const ParticleSource& source, const Particles& particles) {
  if (source.coloring.empty()) return decided(source.material, particles);
  const Rule rule = source.material.rule;
  if (rule != Rule::automatic && rule != Rule::named && rule != Rule::painted) {
    throw SourceError("color_by", "material is " + text_of(source.material) +
                                      ", which says the colour, too: leave one of them out");
  }
  return {Rule::painted, source.material.name};
}

void append_shown(ShownParticles shown, const std::filesystem::path& path,
                  const ParticleSource& source, SceneFile& file, int threads) {
  file.particle_files.push_back({path, source, shown.particles.count(), shown.particles.facts});
  if (!file.cell) file.cell = shown.particles.cell;
  add_legend(file.legends, shown.paint.empty()
                               ? legend_of(shown.particles, source.material, file.materials)
                               : std::move(shown.paint.legend));
  append_spheres(std::move(shown.particles), shown.paint, source, file.materials, file.scene,
                 threads);
}

}  // namespace parray::input
