#pragma once

#include <cstdint>
#include <string_view>

#include "common/rooms.h"

namespace parray::input {

/// What is known of an atom whose element the file does not say.
struct AtomName {
  std::string_view residue;  ///< "ALA"; empty: not known
  std::string_view name;     ///< "CA"
  bool two_letters = false;  ///< PDB: the columns say that a symbol of two letters starts the name
  bool in_molecule = true;   ///< a label of a molecule; else of a crystal, where Ca is calcium
};

/// The element by residue and name, as programs of the field tell it: CA of an amino acid is carbon
/// and CA in a residue CA is calcium, HG is hydrogen, CLA of the residue CLA is chlorine, "1HB2" is
/// hydrogen. A symbol of two letters counts where the ion or the columns say so, or where no
/// name of organic chemistry starts like it ("BR1", "Cl1", "ZN", "FE2").
/// 0: no element (a virtual site, a bead of a coarse model), or not known.
std::uint8_t guess_element(const AtomName& atom);

/// True where such a name of fewer than four characters, when it starts in column 13 of PDB, shows
/// that the file does not keep that column for symbols of two letters ("CA  ALA", "C1  LIG").
bool shows_flush_left(std::string_view residue, std::string_view name);

}  // namespace parray::input
