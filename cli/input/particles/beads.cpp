#include "cli/input/particles/beads.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <string>
#include <vector>

#include "cli/input/color/number_bounds.h"
#include "cli/input/particles/elements.h"
#include "common/scene/limits.h"

namespace parray::input {
namespace {

/// Returns the column of the particles' names. Null: they have none.
const NameColumn* names_of(const Particles& particles) {
  if (!particles.atom_names.empty()) return &particles.atom_names;
  return particles.facts.format == "XYZ" && !particles.types.empty() ? &particles.types : nullptr;
}

std::uint64_t noted(const Particles& particles, std::string_view key) {
  std::uint64_t count = 0;
  for (const ParticleNote& note : particles.facts.notes) count += note.key == key ? note.count : 0;
  return count;
}

/// Returns the positions in the order of the coordinate in which they extend farthest.
std::vector<Vec3d> sorted_along_widest(std::span<const Vec3d> positions) {
  const auto [low, high] = bounds_of(positions);
  const Vec3d extent = high - low;
  std::vector<Vec3d> sorted(positions.begin(), positions.end());
  // The widest coordinate comes first: the others only shift or swap.
  if (extent.y >= extent.x && extent.y >= extent.z) {
    for (Vec3d& p : sorted) p = {p.y, p.z, p.x};
  } else if (extent.z >= extent.x) {
    for (Vec3d& p : sorted) p = {p.z, p.x, p.y};
  }
  std::ranges::sort(sorted, {}, [](const Vec3d& p) { return std::array{p.x, p.y, p.z}; });
  return sorted;
}

/// Returns the distance of the nearest neighbour of a position. `sorted` ascends in x.
double nearest_to(std::size_t place, const std::vector<Vec3d>& sorted) {
  const Vec3d& center = sorted[place];
  double nearest = std::numeric_limits<double>::infinity();
  const auto visit = [&](const Vec3d& other) {
    if (std::abs(other.x - center.x) >= nearest) return false;
    nearest = std::min(nearest, length(other - center));
    return true;
  };
  for (std::size_t i = place + 1; i < sorted.size() && visit(sorted[i]); ++i) {
  }
  for (std::size_t i = place; i > 0 && visit(sorted[i - 1]); --i) {
  }
  return nearest;
}

/// A look with rules that the user and the file leave open.
struct OpenLook {
  ParticleLook* look;
  bool colors;   ///< the colours are open
  double share;  ///< of the radius at which neighbours touch; 0: the radius is not open
};

/// Returns the look of `source` if a rule is open; if it has representations, theirs instead.
std::vector<OpenLook> open_looks(const Particles& particles, ParticleSource& source) {
  std::vector<OpenLook> open;
  const auto add = [&](ParticleLook& look, const ParticleLook& complete) {
    const bool colors = particles.colors.empty() && complete.coloring.empty() &&
                        complete.material.rule == ParticleMaterial::Rule::automatic;
    const bool radius = particles.radii.empty() && complete.radius_by.empty() &&
                        complete.radius.rule == ParticleRadius::Rule::automatic &&
                        complete.style != ParticleStyle::sticks;
    const double share = complete.style == ParticleStyle::balls_and_sticks ? 0.5 : 1;
    if (colors || radius) open.push_back({&look, colors, radius ? share : 0});
  };
  if (source.shows.empty()) add(source.look, source.look);
  for (Representation& show : source.shows) add(show.look, completed(show.look, source.look));
  return open;
}

}  // namespace

double typical_distance(std::span<const Vec3d> positions) {
  if (positions.size() < 2) return 0;
  constexpr std::size_t most = 1000;
  const std::vector<Vec3d> sorted = sorted_along_widest(positions);
  const std::size_t step = (sorted.size() + most - 1) / most;
  std::vector<double> distances;
  for (std::size_t i = 0; i < sorted.size(); i += step) distances.push_back(nearest_to(i, sorted));
  const auto middle = distances.begin() + std::ssize(distances) / 2;
  std::ranges::nth_element(distances, middle);
  return *middle;
}

bool are_beads(const Particles& particles) {
  constexpr double longest_bond = 2;  // angstrom; of light atoms
  const NameColumn* const names = names_of(particles);
  const std::size_t count = particles.count();
  if (names == nullptr || particles.facts.format == "CIF") return false;
  if (particles.elements.empty()) return true;
  std::size_t unknown = 0;
  std::size_t symbols = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const std::uint8_t number = particles.elements[i];
    unknown += number == 0 ? 1 : 0;
    symbols += number != 0 && atomic_number_of(names->of(i)) == number ? 1 : 0;
  }
  if (2 * unknown >= count) return true;
  const std::uint64_t guessed = noted(particles, "guessed_elements");
  return 2 * guessed >= count && 2 * symbols < count &&
         typical_distance(particles.positions) > longest_bond;
}

void decide_for_beads(Particles& particles, ParticleSource& source) {
  const std::vector<OpenLook> looks = open_looks(particles, source);
  if (looks.empty() || !are_beads(particles)) return;
  const bool sized =
      std::ranges::any_of(looks, [](const OpenLook& open) { return open.share > 0; });
  const double touching = sized ? typical_distance(particles.positions) / 2 : 0;
  bool colored = false;
  bool whole = false;
  bool half = false;
  for (const OpenLook& open : looks) {
    if (open.colors) {
      open.look->coloring.by = particles.atom_names.empty() ? "type" : "atom";
      colored = true;
    }
    const double radius = open.share * touching;
    if (radius < ranges::length.least) continue;
    open.look->radius = {ParticleRadius::Rule::fixed, radius};
    (open.share < 1 ? half : whole) = true;
  }
  std::string text = in_number(particles.count(), "bead, whose name is no element",
                               "beads, whose names are no elements");
  if (colored) text += ": coloured by name";
  if (whole || half) {
    text += std::string(colored ? "," : ":") + " with " + (whole ? "" : "half ") +
            "the radius at which neighbours touch" + (whole && half ? ", or half of it" : "");
  }
  std::erase_if(particles.facts.notes, [](const ParticleNote& note) {
    return note.key == "guessed_elements" || note.key == "unknown_elements";
  });
  particles.facts.note("beads", particles.count(), text);
}

}  // namespace parray::input
