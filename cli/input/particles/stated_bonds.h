#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "cli/input/particles/particles.h"

/// Operations on the bonds that a file states (Particles::bonds). Their numbers of particles are
/// below limits::max_shapes.
namespace parray::input {

/// Returns the bond between two different particles, in either order.
StatedBond bond_between(std::uint64_t one, std::uint64_t other);

/// Sorts bonds and removes repeated ones.
void put_in_order(std::vector<StatedBond>& bonds);

/// Removes the bonds of the particles whose mask is 0, and renumbers the other bonds.
void keep_bonds(std::vector<StatedBond>& bonds, const ParticleMask& mask);

/// Adds the bonds of copies, which follow `count` particles. `sources`: the particles that are
/// copied, in the order of the copies.
void append_bonds_of_copies(std::vector<StatedBond>& bonds, std::size_t count,
                            const std::vector<std::size_t>& sources);

/// Returns the bonds between particles, where particle i was the particle order[i] before.
std::vector<StatedBond> renumbered(const std::vector<StatedBond>& bonds,
                                   const std::vector<std::size_t>& order);

}  // namespace parray::input
