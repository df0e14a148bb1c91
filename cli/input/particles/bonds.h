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

/// Where bonds come from.
enum class BondSource : std::uint8_t {
  automatic,  ///< those of the file and, unless the file states all bonds, those of close atoms
  file,       ///< those of the file alone
  off
};

/// A bond to draw. `delta` is the vector from particle `first` to the image of particle `second`
/// that it bonds to, in the unit of the file; never 0. Each half of the bond is drawn at its own
/// particle: from `first` along `delta`, and from `second` against it. `first` and `second` are
/// equal if a particle bonds to its own image.
struct DrawnBond {
  std::uint32_t first = 0;
  std::uint32_t second = 0;
  Vec3d delta;
};

/// Returns the bonds between the particles, with `first` <= `second`, in the order of their
/// particles. The result is the same for the same particles.
///
/// A stated bond leads to the nearest image of the other particle. BondSource::automatic leaves out
/// stated bonds between two hydrogens that both have other bonds, as in rigid water.
///
/// BondSource::automatic also adds covalent_bonds(), unless Particles::all_bonds is true, with
/// these exceptions:
///
/// - Two atoms of the same residue get no such bond if both have stated bonds.
/// - Atoms of two residues bond by the links of polymers (C-N, O3'-P, SG-SG). By other bonds, they
///   bond only if both have no stated bonds and one of them belongs to no amino acid and no
///   nucleotide. Water bonds to no other residue.
/// - Two noble gases do not bond.
/// - Two metals do not bond if one of them bonds to a nonmetal, as in oxides.
/// - Atoms of different alternative locations do not bond. Atoms closer than 0.5 angstrom do not
///   bond, because they share a place.
///
/// A bond across a periodic face is left out if it leads to the place of another particle, such as
/// a copy on that face: the bond to that particle is drawn.
///
/// Throws the errors of covalent_bonds().
std::vector<DrawnBond> drawn_bonds(const Particles& particles, BondSource source);

}  // namespace parray::input
