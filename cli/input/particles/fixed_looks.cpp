#include "cli/input/particles/fixed_looks.h"

#include <algorithm>
#include <cstdint>
#include <string>
#include <string_view>

#include "cli/input/color/particle_colors.h"
#include "cli/input/particles/residues.h"

namespace parray::input {
namespace {

/// Returns the column of names that decides the colours of a look. Null: none does.
NameColumn* deciding_column(const ParticleLook& look, Particles& particles) {
  const std::string& by = look.coloring.by;
  if (by.empty() || by == "type") return &particles.types;
  if (by == "chain") return &particles.chains;
  if (by == "residue") return &particles.residue_names;
  return by == "atom" ? &particles.atom_names : nullptr;
}

/// Returns whether `name` is a group in the legend of residues, not a residue.
bool is_group(std::string_view by, std::string_view name) {
  return by == "residue" && std::ranges::find(residue_groups(), name) != residue_groups().end();
}

/// Makes the ends of a diverging map symmetric if colors_of() would do so.
NumberBounds completed(NumberBounds bounds, const ParticleColoring& coloring) {
  const bool open = coloring.range.open() && coloring.scale != NumberScale::log;
  if (!open || !coloring.map || !is_diverging(*coloring.map)) return bounds;
  if (bounds.low < 0 && bounds.high > 0) bounds.high = std::max(bounds.high, -bounds.low);
  if (bounds.low < 0 && bounds.high > 0) bounds.low = -bounds.high;
  return bounds;
}

void fix(const PartLook& part, const ParticleLook& base, ParticleLook& look) {
  const ParticleLook whole = completed(look, base);
  if (!part.colored.empty()) {
    const NumberBounds ends = completed(part.colored, whole.coloring);
    look.coloring.range = {RangeEnd{ends.low, false}, RangeEnd{ends.high, false}};
  }
  look.coloring.names = part.names;
  if (part.sized.empty()) return;
  look.radius_by = whole.radius_by;
  look.radius_by.numbers = part.sized;
}

}  // namespace

void add_names(const ParticleLook& look, Particles& particles) {
  NameColumn* const column = deciding_column(look, particles);
  if (look.coloring.names.empty() || column == nullptr || column->empty()) return;
  NameColumn out;
  for (const std::string& shown : look.coloring.names) {
    if (is_group(look.coloring.by, shown)) continue;
    out.names.push_back(shown == nameless_category ? "" : shown);
  }
  std::vector<std::uint32_t> number(column->names.size());
  for (std::size_t i = 0; i < number.size(); ++i) {
    const auto found = std::ranges::find(out.names, column->names[i]);
    number[i] = static_cast<std::uint32_t>(found - out.names.begin());
    if (found == out.names.end()) out.names.push_back(column->names[i]);
  }
  out.index.resize(column->index.size());
  std::ranges::transform(column->index, out.index.begin(),
                         [&](std::uint32_t name) { return number[name]; });
  *column = std::move(out);
}

void FixedLooks::add(const std::vector<ParticleFile>& files) {
  for (std::size_t i = 0; i < files.size(); ++i) {
    for (const PartLook& part : files[i].looks) {
      PartLook& look = looks_[{i, part.representation}];
      look.colored.add(part.colored);
      look.sized.add(part.sized);
      for (const std::string& name : part.names) {
        if (std::ranges::find(look.names, name) == look.names.end()) look.names.push_back(name);
      }
    }
    Sizes& sizes = sizes_[i];
    if (sizes.stick_radius == 0) sizes.stick_radius = files[i].stick_radius;
    sizes.arrows.add(files[i].arrow_measure);
  }
}

bool FixedLooks::apply_to(std::vector<ParticleSource>& sources) const {
  bool resized = false;
  for (const auto& [number, sizes] : sizes_) {
    ParticleSource& source = sources.at(number);
    if (!source.look.stick_radius && sizes.stick_radius > 0) {
      source.look.stick_radius = sizes.stick_radius;
      resized = true;
    }
    if (sizes.arrows.longest == 0) continue;
    source.arrow_measure = sizes.arrows;
    resized = true;
  }
  for (const auto& [place, part] : looks_) {
    const auto& [number, representation] = place;
    ParticleSource& source = sources.at(number);
    ParticleLook& look = representation ? source.shows.at(*representation).look : source.look;
    fix(part, representation ? source.look : ParticleLook{}, look);
    resized = resized || !part.sized.empty();
  }
  return resized;
}

}  // namespace parray::input
