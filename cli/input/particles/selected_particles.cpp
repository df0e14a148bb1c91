#include "cli/input/particles/selected_particles.h"

#include <algorithm>
#include <iterator>
#include <span>
#include <string_view>
#include <utility>

#include "cli/input/particles/cell_operations.h"
#include "cli/input/particles/fixed_looks.h"
#include "cli/input/particles/particle_spheres.h"
#include "cli/input/particles/sticks.h"
#include "cli/input/scene_file/scene_sections.h"
#include "cli/input/select/columns.h"
#include "cli/input/select/selection.h"
#include "common/base/error.h"
#include "common/base/printable.h"
#include "common/base/text.h"
#include "common/math/largest_component.h"
#include "common/scene/limits.h"

namespace parray::input {
namespace {

/// Runs `work`. If it needs an unknown number, throws an error that lists the valid names: the
/// `words` that `key` accepts and the numbers of the file.
void with_remedy(const char* key, std::span<const std::string_view> words, PackedFile& file,
                 ParticleRequest request, const auto& work) {
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

ParticleMaterial decided_material(const ParticleLook& look, const Particles& particles) {
  if (look.coloring.empty()) return decided(look.material, particles);
  using Choice = ParticleMaterial::Rule;
  const Choice rule = look.material.rule;
  if (rule != Choice::automatic && rule != Choice::named && rule != Choice::color_by) {
    throw SourceError("color_by", "\"material\" is " + text_of(look.material) +
                                      ", which also sets the colour: leave out one of them");
  }
  return {ParticleMaterial::Rule::color_by, look.material.name};
}

/// Decides the rules of `look`. Afterwards the particles support these rules. `name`: of the file.
void decide(const Particles& particles, const std::string& name, bool crystal,
            const DefaultLook* otherwise, MaterialNames& materials, ParticleLook& look) {
  const auto check = [](const char* key, const std::string& problem) {
    if (!problem.empty()) throw SourceError(key, problem);
  };
  look.material = decided_material(look, particles);
  look.radius = decided(look.radius, particles, crystal);
  std::string_view known = "the name of a material";
  const bool of_sticks = look.style == ParticleStyle::sticks;  // which give balls their radius
  if (otherwise != nullptr) {
    known = otherwise->material_name;
    if (look.material.rule == ParticleMaterial::Rule::automatic) {
      look.material = {ParticleMaterial::Rule::named, std::string(known)};
    }
    if (text_of(look.material) == known) {
      materials.define(otherwise->material_name, otherwise->material);
    }
    if (look.radius.rule == ParticleRadius::Rule::automatic && !of_sticks) {
      look.radius = {ParticleRadius::Rule::fixed, otherwise->radius};
    }
  }
  check("material", problem_with(look.material, particles, materials, name, known));
  const bool open = look.radius.rule == ParticleRadius::Rule::automatic;
  if (!open || !of_sticks) check("radius", problem_with(look.radius, particles, name));
}

/// Returns the bonds to draw. Throws SourceError if the file should state some but has none. Adds a
/// note if there are none.
std::vector<DrawnBond> bonds_to_draw(const ParticleSource& source, Particles& particles) {
  if (source.bonds == BondSource::file && particles.bonds.empty()) {
    throw SourceError("bonds", "the file states no bonds of these particles: use auto or off");
  }
  if (!draws_sticks(source)) return {};
  std::vector<DrawnBond> bonds =
      blaming("bonds", [&] { return drawn_bonds(particles, source.bonds); });
  if (bonds.empty() && source.bonds != BondSource::off) {
    particles.facts.note("no_bonds", particles.count(),
                         particles_word(particles.count()) + " without any bonds, so no sticks");
  }
  return bonds;
}

/// Returns the arrows of a source, if it has any. Throws SourceError that lists the numbers of the
/// file if the file lacks the vectors.
ParticleArrows arrows_to_draw(const ParticleSource& source, Particles& particles, PackedFile& file,
                              ParticleRequest request) {
  if (source.arrows.empty()) return {};
  try {
    return arrows_of(source.arrows, source.arrow_scale, particles, source.arrow_measure);
  } catch (const UnknownNumber&) {
    request.all = true;
    const std::vector<NumberColumn> numbers = read_particles(file, request).numbers;
    std::string names;
    for (const NumberColumn& column : numbers) {
      names += (names.empty() ? "" : ", ") + printable(column.name);
    }
    throw SourceError("arrows",
                      "the file has no vectors '" + printable(source.arrows) +
                          (numbers.size() < 3 ? "': leave out \"arrows\""
                                              : "': leave out \"arrows\", or name three columns of "
                                                "the file, separated by commas: " +
                                                    names));
  }
}

/// Returns the look as a scene file states it.
ParticleLook to_write(ParticleLook look) {
  if (!look.radius_by.empty()) look.radius = {};  // the column that it filled
  return look;
}

/// Returns the numbers by which the source selects, colours, sizes and moves particles, except
/// slices.
std::set<std::string, std::less<>> numbers_of(const ParticleSource& source) {
  std::set<std::string, std::less<>> numbers;
  const auto add_selection = [&](const std::string& text) {
    if (!text.empty()) numbers.merge(Selection(text).numbers());
  };
  const auto add_column = [&](const std::string& name) {
    if (!name.empty() && is_requested_column(name)) numbers.insert(name);
  };
  const auto add_look = [&](const ParticleLook& look) {
    if (!place_in(color_by_words, look.coloring.by)) add_column(look.coloring.by);
    add_column(look.radius_by.by);
  };
  add_selection(source.filter.select);
  add_look(source.look);
  for (const Representation& show : source.shows) {
    add_selection(show.select);
    add_look(show.look);
  }
  add_selection(source.cell.center);
  if (source.cell.whole) {
    numbers.insert("id");
    numbers.insert(molecule_numbers.begin(), molecule_numbers.end());
  }
  return numbers;
}

/// Adds a note for each column of the file that has the name of a number of ParRay's own, if the
/// source uses this number.
void note_hidden_columns(const ParticleSource& source, Particles& particles) {
  for (const std::string& name : numbers_of(source)) {
    if (is_number_column(name) || particles.numbers_named(name) == nullptr) continue;
    particles.facts.note(
        "hidden_column", particles.count(),
        particles_word(particles.count()) + " with a column " + name +
            " that is not used: " + name + " is " +
            (name == "index" ? "the position in the file" : "a fraction of the cell"));
  }
}

/// Returns what the frames of a film must agree on for the look of this part.
PartLook look_of(const ParticlePart& part, const Legend& legend) {
  PartLook look{
      .representation = part.representation, .colored = part.colors.numbers, .sized = part.sized};
  for (const LegendEntry& entry : legend.entries) look.names.push_back(entry.name);
  return look;
}

/// Turns the spheres of a source's particles into the shapes that the source asks for.
class ParticleShapes {
 public:
  /// Begins before the first sphere of the source. All arguments must outlive the object.
  ParticleShapes(const SelectedParticles& selected, const ParticleSource& source, Scene& scene)
      : selected_(selected), source_(source), scene_(scene), first_(scene.spheres.size()) {
    if (!selected.bonds.empty() || !selected.arrows.arrows.empty()) {
      particles_.resize(selected.count);
    }
  }

  /// Call it after append_spheres() for each part. Changes the radii of the spheres of `part`, the
  /// last ones in the scene, by the style of its look, whose automatic rules were replaced: see
  /// shape_spheres().
  void add_part(const ParticlePart& part) {
    const auto spheres = std::span(scene_.spheres).subspan(first_);
    const double stick_radius = part.look.stick_radius.value_or(selected_.stick_radius);
    shape_spheres(part.look, stick_radius, spheres);
    if (!particles_.empty()) {
      const bool sticks = has_sticks(part.look.style);
      for (std::size_t i = 0; i < spheres.size(); ++i) {
        particles_[part.numbers.empty() ? i : part.numbers[i]] = {
            static_cast<std::uint32_t>(first_ + i), sticks ? stick_radius : 0, true};
      }
    }
    first_ = scene_.spheres.size();
  }

  /// Appends the capsules after the last part: those of bonds (append_sticks()), then those of the
  /// arrows in the order of particles, then the edges of the cell if `solid_cell` is set.
  ///
  /// Throws SourceError for "solid_cell" without a cell. Throws InputError "FILE: problem: remedy"
  /// if shapes exceed limits.h; the scene is unusable then.
  void append_capsules() {
    const std::size_t first = scene_.capsules.size();
    append_sticks(selected_.bonds, particles_, scene_);
    const ParticleArrows& arrows = selected_.arrows;
    for (std::size_t i = 0; i < arrows.arrows.size(); ++i) {
      if (!particles_[i].shown) continue;
      const Sphere& sphere = scene_.spheres[particles_[i].sphere];
      append_arrow(sphere.center, arrows.arrows[i], arrows.width, sphere.material, scene_.capsules);
    }
    if (source_.solid_cell) append_edges();
    check_limits(first);
  }

 private:
  void append_edges() {
    if (!selected_.cell) {
      throw SourceError("solid_cell", "the file has no box and no cell: leave it out");
    }
    const auto known = std::ranges::find(scene_.materials, cell_material);
    const auto material = static_cast<std::uint32_t>(known - scene_.materials.begin());
    if (known == scene_.materials.end()) scene_.materials.push_back(cell_material);
    append_cell(*selected_.cell, material, scene_.capsules);
  }

  void check_limits(std::size_t first_capsule) const {
    const FilePlace place{source_.file};
    if (scene_.spheres.size() + scene_.capsules.size() > limits::max_shapes) {
      place.fail("more than " + std::to_string(limits::max_shapes) +
                 " spheres and capsules in all: split the scene");
    }
    const auto inside = [](const Vec3d& p) { return largest_component(p) <= limits::max_length; };
    for (const Capsule& capsule : std::span(scene_.capsules).subspan(first_capsule)) {
      if (inside(capsule.from) && inside(capsule.to)) continue;
      place.fail(
          "a bond, an arrow or an edge of the cell would reach beyond 1e15: use a larger unit of "
          "length in the file, or shorter arrows");
    }
  }

  const SelectedParticles& selected_;
  const ParticleSource& source_;
  Scene& scene_;
  std::size_t first_;                     // sphere of the next part
  std::vector<DrawnParticle> particles_;  // empty without bonds and arrows
};

/// Expands one source. Errors name the place in the scene file that refers to the particle file,
/// then the problem in the particle file.
void expand(ParticleSource source, const JsonPlace& place, const std::filesystem::path& folder,
            SceneFile& file, int threads, OpenTrajectories& open) {
  source.cell.crystal = source.cell.crystal.value_or(false);
  try {
    const std::filesystem::path path = folder / source.file;
    auto& [particles, cursor] = open.try_emplace(path, path).first->second;
    ParticleRequest request = request_of(source, folder, threads);
    request.cursor = &cursor;
    Particles all = read_particles(particles, request);
    Particles shown = selected(std::move(all), particles, source, request);
    append_parts(parts_of(std::move(shown), particles, source, request), particles.path(), source,
                 file, threads);
  } catch (const SourceError& error) {
    if (source.line == 0) fail_in_options(error, source, (folder / source.file).string());
    fail_in(source, place, error.key(), error.representation(), error.what());
  } catch (const InputError& error) {
    if (source.line == 0) throw;
    place.at("file").fail(source.line_of("file"), error.what());
  }
}

}  // namespace

ParticleRequest request_of(const ParticleSource& source, const std::filesystem::path& folder,
                           int threads) {
  ParticleRequest request{
      .frame = source.frame, .alternatives = source.alternatives, .threads = threads};
  if (!source.topology.empty()) request.topology = folder / source.topology;
  request.numbers = numbers_of(source);
  request.numbers.merge(numbers_of_arrows(source.arrows));
  return request;
}

Particles selected(Particles particles, PackedFile& file, ParticleSource& source,
                   const ParticleRequest& request) {
  const int threads = request.threads;
  CellOperations& operations = source.cell;
  if (!operations.crystal && is_crystal(particles)) operations.crystal = true;
  with_remedy("center", {}, file, request, [&] { apply(operations, particles, threads); });
  with_remedy("select", {}, file, request, [&] { apply(source.filter, particles, threads); });
  return particles;
}

SelectedParticles parts_of(Particles particles, PackedFile& file, const ParticleSource& source,
                           const ParticleRequest& request) {
  const int threads = request.threads;
  const std::size_t count = particles.count();
  note_hidden_columns(source, particles);
  std::vector<DrawnBond> bonds = bonds_to_draw(source, particles);
  const double stick_radius = draws_sticks(source) ? stick_radius_of(particles, bonds) : 0;
  ParticleArrows arrows = arrows_to_draw(source, particles, file, request);
  std::vector<ParticlePart> parts;
  with_remedy("show", {}, file, request, [&] { parts = split(particles, source, threads); });
  SelectedParticles selected{.facts = std::move(particles.facts),
                             .cell = particles.cell,
                             .parts = std::move(parts),
                             .count = count,
                             .bonds = std::move(bonds),
                             .stick_radius = stick_radius,
                             .arrows = std::move(arrows),
                             .topology = request.topology};
  for (ParticlePart& part : selected.parts) {
    in_representation(part.representation, [&] {
      add_names(part.look, part.particles);
      if (!part.look.radius_by.empty()) {
        with_remedy("radius_by", {}, file, request,
                    [&] { part.sized = apply(part.look.radius_by, part.particles); });
      }
      if (part.look.coloring.empty()) return;
      with_remedy("color_by", color_by_words, file, request,
                  [&] { part.colors = colors_of(part.look.coloring, part.particles, threads); });
    });
  }
  return selected;
}

void fail_in_options(const SourceError& error, const ParticleSource& source,
                     const std::string& file) {
  const bool named = error.key() == "material" || error.key() == "radius";  // names the file
  std::string text = error.what();
  if (!named && !(error.representation() && error.key() == "select")) {
    text = '"' + error.key() + "\": " + text;
  }
  text = naming_options(text);
  if (error.representation()) {
    text = "--show '" + printable(source.shows[*error.representation()].select) + "': " + text;
  } else if (named) {
    throw InputError(text);
  }
  FilePlace{file}.fail(text);
}

ParticleSource append_parts(SelectedParticles selected, const std::filesystem::path& path,
                            ParticleSource source, SceneFile& file, int threads,
                            const DefaultLook* otherwise) {
  ParticleShapes shapes(selected, source, file.scene);
  ParticleFile shown{path, std::move(selected.topology), {}, 0, std::move(selected.facts)};
  const bool sticks = !selected.bonds.empty();
  if (sticks && selected.parts.front().particles.elements.empty()) {
    shown.stick_radius = selected.stick_radius;
  }
  shown.arrow_measure = selected.arrows.measure;
  if (!file.cell) file.cell = selected.cell;
  for (ParticlePart& part : selected.parts) {
    in_representation(part.representation, [&] {
      decide(part.particles, source.file, source.cell.crystal.value_or(false), otherwise,
             file.materials, part.look);
    });
    shown.count += part.particles.count();
    std::ranges::move(part.particles.facts.notes, std::back_inserter(shown.facts.notes));
    (part.representation ? source.shows[*part.representation].look : source.look) =
        to_write(part.look);
    Legend legend = part.colors.empty() ? legend_of(part.particles, part.look.material,
                                                    file.materials, part.look.coloring.names)
                                        : std::move(part.colors.legend);
    shown.looks.push_back(look_of(part, legend));
    add_legend(file.legends, std::move(legend));
    append_spheres(std::move(part.particles), part.colors, part.look, source.file, file.materials,
                   file.scene, threads);
    shapes.add_part(part);
  }
  shapes.append_capsules();
  add_legend(file.legends, std::move(selected.arrows.legend));
  file.solid_cell = file.solid_cell || source.solid_cell;
  shown.source = source;
  file.particle_files.push_back(std::move(shown));
  return source;
}

void expand_particles(SceneFile& file, const std::filesystem::path& scene_path, int threads,
                      OpenTrajectories* open) {
  OpenTrajectories opened_here;
  const std::string name = scene_path.string();
  const JsonPlace root(name);
  const JsonPlace section = root.at("particles");
  for (std::size_t i = 0; i < file.particles.size(); ++i) {
    expand(file.particles[i], section.at(i), scene_path.parent_path(), file, threads,
           open != nullptr ? *open : opened_here);
  }
  file.particles.clear();
}

}  // namespace parray::input
