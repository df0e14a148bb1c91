#include "cli/input/particles/drawn_bonds.h"

namespace parray::input {

std::vector<DrawnBond> drawn_bonds(const Particles& particles, BondSource source) {
  std::vector<DrawnBond> drawn;
  if (source == BondSource::off) return drawn;
  for (const StatedBond& bond : particles.bonds) {
    drawn.push_back({bond.first, bond.second,
                     particles.positions[bond.second] - particles.positions[bond.first]});
  }
  return drawn;
}

}  // namespace parray::input
