#pragma once

#include <span>

#include "cli/input/particles/particles.h"
#include "cli/input/scene_file/particle_source.h"

/// The beads of coarse models, whose names are no elements.
namespace parray::input {

/// Returns whether the particles of a file are beads. They have names, the file is no CIF file, and
/// - the elements of at least half of the particles are unknown, or
/// - elements were guessed for at least half of the particles, most names are not just the symbol
///   of an element, and typical neighbours are more than 2 angstrom apart: too far for bonds of
///   atoms.
/// `particles` are all particles of the file.
bool are_beads(const Particles& particles);

/// Returns the median distance from a particle to its nearest neighbour among all particles. Takes
/// the median over at most 1000 particles. Returns 0 for fewer than two particles.
double typical_distance(std::span<const Vec3d> positions);

/// If the particles are beads, sets the rules that neither the user nor the file decides: in the
/// look of `source` or, if it has representations, in their looks. The colours are then by name,
/// and the radius is the one with which typical neighbours touch. Balls between sticks get half of
/// this radius. Sticks keep their own radius. One note then replaces the notes about elements. Does
/// nothing if no rule is open.
void decide_for_beads(Particles& particles, ParticleSource& source);

}  // namespace parray::input
