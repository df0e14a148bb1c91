#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "cli/input/particles/bonds.h"
#include "cli/input/particles/particles.h"
#include "cli/input/scene_file/particle_source.h"
#include "common/scene/scene.h"

/// Turns bonds into sticks, and the edges of a cell into rods. Both are capsules.
namespace parray::input {

/// Most atoms of a molecule that automatic scenes draw as balls and sticks.
inline constexpr std::size_t most_atoms_with_sticks = 500;

/// Returns whether a style draws bonds.
constexpr bool has_sticks(ParticleStyle style) {
  return style == ParticleStyle::balls_and_sticks || style == ParticleStyle::sticks;
}

/// Returns whether the source draws bonds in any of its looks.
bool draws_sticks(const ParticleSource& source);

/// Decides the automatic styles of an automatic scene. `particles` are all that the source shows.
/// Changes nothing unless all of them are atoms of known elements whose file has no radii. A small
/// molecule becomes balls and sticks: at most most_atoms_with_sticks atoms, no crystal, and with a
/// bond that is not between two metals. Atoms without bonds are balls, too.
///
/// If the atoms are no small molecule but have arrows, they become balls, because larger spheres
/// would hide the arrows. The source then draws no bonds, unless another look has a style with
/// sticks, or the user chose BondSource::file. Looks with `radius_by`, or with a radius rule other
/// than `automatic` and `fixed`, keep the style `automatic`, which means spheres.
void decide_style(const Particles& particles, ParticleSource& source);

/// Returns the default radius of sticks, in the particles' unit of length: 0.15 angstrom. For
/// particles without elements: a tenth of the mean length of the bonds or, without bonds, of
/// typical_distance().
double stick_radius_of(const Particles& particles, const std::vector<DrawnBond>& bonds);

/// Gives the spheres of particles the radii of look.style. The automatic rules of `look` were
/// replaced by decided(). `spheres` have the radii of look.radius or look.radius_by.
/// - balls_and_sticks: 0.25 of the radius by element or column, 0.5 of the covalent radius. A
///   number and radius_by stay as they are.
/// - sticks: `stick_radius`.
/// - spheres: no change.
void shape_spheres(const ParticleLook& look, double stick_radius, std::span<Sphere> spheres);

/// A particle in a scene.
struct DrawnParticle {
  std::uint32_t sphere = 0;  ///< its number in the scene
  double stick_radius = 0;   ///< 0: its style has no sticks
  bool shown = false;        ///< it has a sphere
};

/// Appends two capsules for each bond, in order: from each particle to the middle of the bond, with
/// the material of the particle. Leaves out halves of particles without sticks, bonds of particles
/// that are not shown, and bonds of length 0. `particles` has an entry for each number in `bonds`.
void append_sticks(const std::vector<DrawnBond>& bonds, const std::vector<DrawnParticle>& particles,
                   Scene& scene);

/// Appends capsules of `material` for the twelve edges of the cell. Their radius is 0.6 % of the
/// mean edge.
void append_cell(const ParticleCell& cell, std::uint32_t material, std::vector<Capsule>& capsules);

/// The material of the edges of a cell.
inline constexpr Material cell_material{MaterialType::diffuse, {0.2, 0.2, 0.2}, 0, 1};

}  // namespace parray::input
