#pragma once

#include <cstdint>
#include <vector>

#include "cli/input/particles/particles.h"

namespace parray::input {

/// Where bonds come from.
enum class BondSource : std::uint8_t {
  automatic,  ///< those of the file; without them, residue templates and covalent distances
  file,       ///< those of the file alone
  off
};

/// A bond to draw. `delta` is the vector from particle `first` to the nearest image of particle
/// `second`. Each half of the bond is drawn at its own particle.
struct DrawnBond {
  std::uint32_t first = 0;
  std::uint32_t second = 0;
  Vec3d delta;
};

/// Returns the bonds between the particles, in the order of their particles. The result is the same
/// for the same particles.
std::vector<DrawnBond> drawn_bonds(const Particles& particles, BondSource source);

}  // namespace parray::input
