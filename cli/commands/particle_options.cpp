#include "cli/commands/particle_options.h"

#include <array>
#include <string_view>
#include <utility>

#include "cli/commands/options.h"
#include "cli/input/select/expression.h"
#include "cli/input/view/auto_scene.h"
#include "common/base/error.h"
#include "common/base/printable.h"
#include "common/base/suggest.h"
#include "common/base/text.h"
#include "common/scene/limits.h"
#include "common/scene/scene_ranges.h"

namespace parray::commands {
namespace {

using MaterialRule = ParticleMaterial::Rule;
using RadiusRule = ParticleRadius::Rule;

ParticleMaterial material_in(const std::string& text) {
  static constexpr std::array<std::string_view, 4> words{"by-element", "by-type", "column",
                                                         plain_material_name};
  ParticleMaterial material = particle_material_from(text);
  if (material.rule == MaterialRule::named && text != plain_material_name) {
    throw InputError("unknown material '" + printable(text) + "': " + remedy_for_name(text, words));
  }
  return material;
}

ParticleRadius radius_in(const std::string& text) {
  const std::optional<ParticleRadius> word = particle_radius_from(text);
  return word ? *word : ParticleRadius{RadiusRule::fixed, real_number(text, ranges::length)};
}

FrameChoice frame_in(const std::string& text) {
  if (text == last_frame_word) return {0, true};
  const std::optional<std::uint64_t> number = natural_in(text);
  if (number && *number <= limits::max_frame) return {*number, false};
  throw InputError("'" + printable(text) + "' is not a frame: write a number from 0 to " +
                   std::to_string(limits::max_frame) + ", or last");
}

AlternativeChoice alternatives_in(const std::string& text) {
  const std::optional<AlternativeChoice> choice = alternatives_from(text);
  if (choice) return *choice;
  throw InputError("'" + printable(text) + "' is not a choice: write best, all or one letter");
}

}  // namespace

void ParticleOptions::add_to(Command& command) {
  command
      .option(
          "--frame", [this](const std::string& text) { frame_ = frame_in(text); },
          "Frame of the file, from 0 (default: the first frame that has particles)")
      .words({std::string(last_frame_word)})
      .type_name("N|last")
      .group(particles_group)
      .special();
  command
      .option(
          "--topology", topology_,
          "File with the elements and names for a trajectory that lacks them: PDB, PSF, PRMTOP ...")
      .forbid_empty()
      .completes(Completes::files)
      .type_name("FILE")
      .group(particles_group)
      .special();
  command
      .option(
          "--alternatives",
          [this](const std::string& text) { alternatives_ = alternatives_in(text); },
          "Alternative locations of an atom to show: best (highest occupancy), all, or those with "
          "a letter (default: best)")
      .words({"best", "all"})
      .type_name("best|all|LETTER")
      .group(particles_group)
      .special();
  command
      .option(
          "--material", [this](const std::string& text) { material_ = material_in(text); },
          "Surface of the particles (default: column, else by-element, else by-type, else plain)")
      .words({"by-element", "by-type", "column", "plain"})
      .group(particles_group)
      .special();
  command
      .option(
          "--radius", [this](const std::string& text) { radius_ = radius_in(text); },
          "Radius of the particles (default: column, else by-element, else half the mean spacing)")
      .words({"by-element", "column"})
      .type_name("R|by-element|column")
      .group(particles_group)
      .special();
  add_filter_to(command);
  add_coloring_to(command);
}

void ParticleOptions::add_filter_to(Command& command) {
  command
      .option(
          "--select", [this](const std::string& text) { filter_.select = select_from(text); },
          "Show only these particles: 'chain A B and not water', 'element C N O', 'z > 10', "
          "'within 5 of resname HEM' (scenes/README.md describes the language)")
      .type_name("TEXT")
      .group(particles_group);
  command
      .option(
          "--slice", [this](const std::string& text) { filter_.slice = slice_from(text); },
          "Show only the particles of a slice: z=10:20, or z=40%:60% of the cell. Separate several "
          "slices by commas")
      .type_name("AXIS=LOW:HIGH")
      .group(particles_group)
      .special();
  std::vector<std::string> classes(selection_classes().begin(), selection_classes().end());
  classes.emplace_back("none");
  command
      .option(
          "--hide", [this](const std::string& text) { filter_.hide = hide_from(text); },
          "Hide these classes. Virtual sites are always hidden, except with `none` (default: "
          "virtual)")
      .words(classes, true)
      .group(particles_group);
}

void ParticleOptions::add_coloring_to(Command& command) {
  command
      .option(
          "--color-by", [this](const std::string& text) { coloring_.by = color_by_from(text); },
          "Colour the particles by a category, or by a number such as vx, charge, b_factor or z")
      .words({color_by_words.begin(), color_by_words.end()})
      .type_name("WORD|NUMBER")
      .group(particles_group);
  command
      .option(
          "--colormap", [this](const std::string& text) { coloring_.map = color_map_from(text); },
          "Colour map for numbers, from low to high (default: viridis)")
      .words({color_map_names().begin(), color_map_names().end()})
      .group(particles_group)
      .special();
  command
      .option(
          "--range", [this](const std::string& text) { coloring_.range = color_range_from(text); },
          "Values at the ends of the colour map: two numbers, or percentiles such as 1%:99% "
          "(default: the smallest and the largest value)")
      .type_name("LOW:HIGH")
      .group(particles_group)
      .special();
}

void ParticleOptions::check_unused(const std::string& file) const {
  std::string given;
  if (frame_) given += " --frame";
  if (!topology_.empty()) given += " --topology";
  if (alternatives_) given += " --alternatives";
  if (material_.rule != MaterialRule::automatic) given += " --material";
  if (radius_.rule != RadiusRule::automatic) given += " --radius";
  if (!filter_.select.empty()) given += " --select";
  if (!filter_.slice.empty()) given += " --slice";
  if (filter_.hide) given += " --hide";
  if (!coloring_.by.empty()) given += " --color-by";
  if (coloring_.map) given += " --colormap";
  if (!coloring_.range.open()) given += " --range";
  if (given.empty()) return;
  throw InputError(
      given.substr(1) + ": " + printable(file, 4096) +
      " is not a particle file: change its section \"particles\" instead of using options "
      "for particle files");
}

ParticleSource ParticleOptions::over(ParticleSource source) const {
  if (frame_) source.frame = frame_;
  if (!topology_.empty()) source.topology = topology_;
  if (alternatives_) source.alternatives = *alternatives_;
  if (material_.rule != MaterialRule::automatic) source.material = material_;
  if (radius_.rule != RadiusRule::automatic) source.radius = radius_;
  if (!filter_.select.empty()) source.filter.select = filter_.select;
  if (!filter_.slice.empty()) source.filter.slice = filter_.slice;
  if (filter_.hide) source.filter.hide = filter_.hide;
  if (!coloring_.by.empty()) source.coloring.by = coloring_.by;
  if (coloring_.map) source.coloring.map = coloring_.map;
  if (!coloring_.range.open()) source.coloring.range = coloring_.range;
  if (const auto problem = problem_with(source.coloring)) {
    throw InputError("--" + problem->key + " " + problem->text);
  }
  return source;
}

}  // namespace parray::commands
