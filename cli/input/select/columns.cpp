#include "cli/input/select/columns.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "cli/input/particles/cell.h"
#include "common/base/suggest.h"
#include "common/base/text.h"

namespace parray::input {
namespace {

constexpr std::array<std::string_view, 9> own_numbers{"x",  "y",      "z",     "fx",   "fy",
                                                      "fz", "radius", "index", "resid"};

struct Fraction {
  Vec3d origin;
  Vec3d slope;
};

/// Returns the fraction along an edge of the cell: 0 at the plane of the other two edges, 1 at the
/// opposite plane. Returns nothing for a flat cell.
std::optional<Fraction> fraction_of(const ParticleCell& cell, std::size_t axis) {
  const auto& edges = cell.edges;
  const Vec3d normal = cross(edges[(axis + 1) % 3], edges[(axis + 2) % 3]);
  const double volume = dot(normal, edges[axis]);
  if (volume == 0 || !std::isfinite(1 / volume)) return {};
  return Fraction{cell.origin, (1 / volume) * normal};
}

/// Returns the fraction along an axis of the box around all centres. The fraction is 0 if the box
/// is flat there.
Fraction fraction_of(const std::vector<Vec3d>& positions, std::size_t axis) {
  const auto [low, high] = std::ranges::minmax(
      positions, {}, [axis](const Vec3d& position) { return component(position, axis); });
  const double extent = component(high, axis) - component(low, axis);
  const double slope = extent > 0 ? 1 / extent : 0;
  return {low, {axis == 0 ? slope : 0, axis == 1 ? slope : 0, axis == 2 ? slope : 0}};
}

/// Returns the source of the numbers number_of(i).
NumberSource each(const auto& number_of) {
  return [number_of](std::size_t begin, std::span<double> out) {
    for (std::size_t i = 0; i < out.size(); ++i) out[i] = number_of(begin + i);
  };
}

}  // namespace

bool is_number_column(std::string_view name) { return !place_in(own_numbers, name); }

bool is_requested_column(std::string_view name) {
  return is_number_column(name) || name == "fx" || name == "fy" || name == "fz" || name == "index";
}

NumberSource number_source(std::string_view name, const Particles& particles) {
  const std::vector<Vec3d>& positions = particles.positions;
  const std::optional<std::size_t> place = place_in(own_numbers, name);
  if (!place) {
    const NumberColumn* const column = particles.numbers_named(name);
    if (column == nullptr) return {};
    return each([column](std::size_t i) { return column->values[i]; });
  }
  const std::size_t axis = *place % 3;
  if (*place < 3) return each([&, axis](std::size_t i) { return component(positions[i], axis); });
  if (*place < 6) {
    std::optional<Fraction> fraction;
    if (particles.cell) fraction = fraction_of(*particles.cell, axis);
    if (!fraction && !positions.empty()) fraction = fraction_of(positions, axis);
    return each([&, f = fraction.value_or(Fraction{})](std::size_t i) {
      return dot(positions[i] - f.origin, f.slope);
    });
  }
  if (name == "index") {
    return each([&](std::size_t i) { return static_cast<double>(particles.index_of(i)); });
  }
  if (name == "radius") {
    if (particles.radii.empty()) return {};
    return each([&](std::size_t i) { return particles.radii[i]; });
  }
  if (particles.residue_numbers.empty()) return {};
  return each([&](std::size_t i) { return static_cast<double>(particles.residue_numbers[i]); });
}

bool is_length_number(std::string_view name) {
  return name == "x" || name == "y" || name == "z" || name == "radius";
}

std::string unit_of(std::string_view name, const Particles& particles) {
  if (is_length_number(name)) return particles.facts.length_unit;
  if (!is_number_column(name)) return {};
  const NumberColumn* const column = particles.numbers_named(name);
  return column == nullptr ? "" : column->unit;
}

std::vector<std::string> number_names(const Particles& particles) {
  std::vector<std::string> names;
  for (const std::string_view name : own_numbers) {
    if (number_source(name, particles)) names.emplace_back(name);
  }
  for (const NumberColumn& column : particles.numbers) {
    if (is_number_column(column.name)) names.push_back(column.name);
  }
  return names;
}

const NameColumn& name_column(std::string_view word, const Particles& particles) {
  if (word == "type") return particles.types;
  if (word == "name") return particles.atom_names;
  return word == "chain" ? particles.chains : particles.residue_names;
}

std::string plural_of(std::string_view word) {
  if (word == "type") return "types";
  if (word == "name") return "atom names";
  return word == "chain" ? "chains" : "residue names";
}

std::string columns_of(const Particles& particles) {
  std::vector<std::string> columns;
  if (!particles.elements.empty()) columns.emplace_back("elements");
  for (const std::string_view word : {"type", "name", "resname", "chain"}) {
    if (!name_column(word, particles).empty()) columns.push_back(plural_of(word));
  }
  for (std::string& name : number_names(particles)) columns.push_back(std::move(name));
  const std::vector<std::string_view> names(columns.begin(), columns.end());
  return list_names(names);
}

}  // namespace parray::input
