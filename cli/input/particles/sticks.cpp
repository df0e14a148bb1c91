#include "cli/input/particles/sticks.h"

#include <algorithm>

#include "cli/input/particles/beads.h"
#include "cli/input/particles/bonds.h"
#include "cli/input/particles/elements.h"
#include "common/base/error.h"
#include "common/scene/limits.h"
#include "common/scene/scene_bytes.h"

namespace parray::input {
namespace {

bool has_radius_rule(const ParticleLook& look) {
  using Rule = ParticleRadius::Rule;
  const bool open = look.radius.rule == Rule::automatic || look.radius.rule == Rule::fixed;
  return !open || !look.radius_by.empty();
}

/// Returns whether there are bonds other than those between two metals. Returns false for atoms
/// that are too close for bonds.
bool has_molecules(const Particles& particles, BondSource source) {
  const auto metal = [&](std::uint32_t i) { return is_metal(particles.elements[i]); };
  try {
    return std::ranges::any_of(drawn_bonds(particles, source), [&](const DrawnBond& bond) {
      return !metal(bond.first) || !metal(bond.second);
    });
  } catch (const InputError&) {
    return false;
  }
}

/// Returns whether the particles are atoms of known elements, without radii of the file.
bool are_atoms(const Particles& particles) {
  const bool beads = std::ranges::count(particles.facts.notes, "beads", &ParticleNote::key) > 0;
  return !particles.elements.empty() && std::ranges::count(particles.elements, 0) == 0 && !beads &&
         particles.radii.empty();
}

bool is_small_molecule(const Particles& particles, const ParticleSource& source) {
  return particles.count() <= most_atoms_with_sticks && !source.cell.crystal.value_or(false) &&
         has_molecules(particles, source.bonds);
}

/// Returns the share of its usual radius that a ball has between sticks.
double share_of_ball(const ParticleLook& look) {
  constexpr double share = 0.25;             // of a van der Waals radius
  constexpr double share_of_covalent = 0.5;  // about the same size
  switch (look.radius.rule) {
    case ParticleRadius::Rule::by_element: return share;
    case ParticleRadius::Rule::covalent: return share_of_covalent;
    case ParticleRadius::Rule::column: return look.radius_by.empty() ? share : 1;
    default: return 1;
  }
}

double in_range(double radius) {
  return std::clamp(radius, limits::min_radius, limits::max_length);
}

constexpr Vec3d zero{};  // adding it turns -0 into 0, so that equal scenes have equal bytes

}  // namespace

bool draws_sticks(const ParticleSource& source) {
  return has_sticks(source.look.style) ||
         std::ranges::any_of(
             source.shows, [](const Representation& show) { return has_sticks(show.look.style); });
}

void decide_style(const Particles& particles, ParticleSource& source) {
  std::vector<ParticleLook*> open;
  const auto consider = [&](ParticleLook& look, const ParticleLook& whole) {
    if (whole.style == ParticleStyle::automatic && !has_radius_rule(whole)) open.push_back(&look);
  };
  if (source.shows.empty()) consider(source.look, source.look);
  for (Representation& show : source.shows) consider(show.look, completed(show.look, source.look));
  if (open.empty() || !are_atoms(particles)) return;
  if (!is_small_molecule(particles, source)) {
    if (source.arrows.empty()) return;
    const bool bonds_wanted = draws_sticks(source) || source.bonds == BondSource::file;
    if (!bonds_wanted) source.bonds = BondSource::off;
  }
  for (ParticleLook* look : open) look->style = ParticleStyle::balls_and_sticks;
}

double stick_radius_of(const Particles& particles, const std::vector<DrawnBond>& bonds) {
  constexpr double usual = 0.15;  // angstrom
  constexpr double share = 0.1;   // of a bond; the same for bonds of carbon
  if (!particles.elements.empty()) return in_range(usual * angstrom_of(particles));
  double sum = 0;
  for (const DrawnBond& bond : bonds) sum += length(bond.delta);
  if (sum > 0) return in_range(share * sum / static_cast<double>(bonds.size()));
  const double distance = typical_distance(particles.positions);
  return distance > 0 ? in_range(share * distance) : usual;
}

void shape_spheres(const ParticleLook& look, double stick_radius, std::span<Sphere> spheres) {
  if (!has_sticks(look.style)) return;
  const bool sticks = look.style == ParticleStyle::sticks;
  const double share = share_of_ball(look);
  for (Sphere& sphere : spheres) {
    sphere.radius = sticks ? stick_radius : in_range(share * sphere.radius);
  }
}

void append_sticks(const std::vector<DrawnBond>& bonds, const std::vector<DrawnParticle>& particles,
                   Scene& scene) {
  const auto add = [&](const DrawnParticle& particle, const Vec3d& half) {
    if (particle.stick_radius == 0) return;
    const Sphere& sphere = scene.spheres[particle.sphere];
    const Capsule capsule{sphere.center, sphere.center + half + zero, particle.stick_radius,
                          sphere.material};
    if (capsule.from != capsule.to && scene::has_valid_ends(capsule)) {
      scene.capsules.push_back(capsule);
    }
  };
  for (const DrawnBond& bond : bonds) {
    if (!particles[bond.first].shown || !particles[bond.second].shown) continue;
    add(particles[bond.first], 0.5 * bond.delta);
    add(particles[bond.second], -0.5 * bond.delta);
  }
}

void append_cell(const ParticleCell& cell, std::uint32_t material, std::vector<Capsule>& capsules) {
  constexpr double share = 0.006;
  const auto& edges = cell.edges;
  const double mean = (length(edges[0]) + length(edges[1]) + length(edges[2])) / 3;
  for (std::size_t edge = 0; edge < edges.size(); ++edge) {
    const Vec3d& u = edges.at((edge + 1) % 3);
    const Vec3d& v = edges.at((edge + 2) % 3);
    for (const Vec3d& from : {cell.origin, cell.origin + u, cell.origin + v, cell.origin + u + v}) {
      capsules.push_back(
          {from + zero, from + edges.at(edge) + zero, in_range(share * mean), material});
    }
  }
}

}  // namespace parray::input
