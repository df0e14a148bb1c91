#pragma once

#include <cstdint>
#include <vector>

#include "cli/input/particles/cell.h"
#include "cli/input/particles/particles.h"

namespace parray::input {

/// A bond between two atoms, by their indices. `image` is the number of cell edges to add to the
/// position of `to`, so that it lies beside `from`. In a small cell, `from` and `to` can be the
/// same atom, and two atoms can have several bonds with different images.
struct PeriodicBond {
  std::uint32_t from = 0;
  std::uint32_t to = 0;
  CellImage image{};
};

/// Returns the length of 1 angstrom in the unit of the particles. Files without a unit, or with an
/// ambiguous one, are in angstrom.
double angstrom_of(const Particles& particles);

/// Finds bonds, also across periodic faces of the cell, if the particles have a cell. Two atoms
/// bond if their distance is at most the sum of their covalent radii and 0.4 angstrom: Meng and
/// Lewis, J. Comput. Chem. 12 (1991) 891. Atoms of unknown elements, is_ionic() elements and pairs
/// of hydrogen do not bond. Returns none without a column of elements. Takes time in proportion to
/// the atoms. Returns each bond once, and the same bonds in the same order for the same particles.
///
/// Throws InputError, which names no place, if atoms or opposite faces of the cell are so close
/// that their unit cannot be right.
std::vector<PeriodicBond> covalent_bonds(const Particles& particles);

}  // namespace parray::input
