#include "cli/input/particles/particle_mask.h"

#include <cstddef>

namespace parray::input {
namespace {

template <typename T>
void keep_in(std::vector<T>& column, const ParticleMask& mask) {
  if (column.empty()) return;
  std::size_t kept = 0;
  for (std::size_t i = 0; i < mask.size(); ++i) {
    if (mask[i] != 0) column[kept++] = column[i];
  }
  column.resize(kept);
}

}  // namespace

void keep(Particles& particles, const ParticleMask& mask) {
  keep_in(particles.radii, mask);
  keep_in(particles.colors, mask);
  keep_in(particles.elements, mask);
  keep_in(particles.types.index, mask);
  keep_in(particles.atom_names.index, mask);
  keep_in(particles.residue_names.index, mask);
  keep_in(particles.chains.index, mask);
  keep_in(particles.residue_numbers, mask);
  for (NumberColumn& column : particles.numbers) keep_in(column.values, mask);
  keep_in(particles.positions, mask);
}

}  // namespace parray::input
