#pragma once

#include <array>
#include <cstdint>
#include <string_view>
#include <vector>

#include "cli/input/particles/particles.h"

namespace parray::input {

/// Names of the numbers that make_whole() uses if the file has no elements.
inline constexpr std::array<std::string_view, 2> molecule_numbers{"mol", "molecule"};

/// The molecules of particles.
struct Molecules {
  std::vector<std::uint32_t> of;  ///< number of each particle's molecule, from 0
  std::uint64_t endless = 0;      ///< molecules that bond to their own images, as in crystals
};

/// Moves particles by whole edges of their cell, which they must have, so that no face of the cell
/// breaks a molecule. The first particle of each molecule stays where it is. Endless molecules stay
/// as they are, and each of their atoms counts as a molecule.
///
/// If the file has elements, molecules follow from covalent_bonds(). Otherwise they follow from the
/// numbers `mol` or `molecule`, or from residues. In these cases each particle moves to the image
/// nearest to the particle before it in the same molecule, in the order of the numbers `id`, if the
/// particles have them.
///
/// Throws InputError, which names no place, if the particles have none of these columns. Passes on
/// the errors of covalent_bonds().
Molecules make_whole(Particles& particles);

}  // namespace parray::input
