#pragma once

#include <cstdint>
#include <string_view>
#include <vector>

#include "cli/input/particles/particles.h"

namespace parray::input {

/// What is known of an atom whose file does not give the element.
struct AtomName {
  std::string_view residue;  ///< "ALA"; empty: unknown
  std::string_view name;     ///< "CA"
  bool two_letters = false;  ///< PDB: columns say that the symbol has two letters
  bool in_molecule = true;   ///< false: a label of a crystal, in which Ca is calcium
};

/// Returns the element by residue and name, as programs of the field do: CA of an amino acid is
/// carbon, CA in a residue CA is calcium, HG is hydrogen, CLA of the residue CLA is chlorine,
/// "1HB2" is hydrogen. A symbol of two letters counts if the ion or the columns say so, or if no
/// name of organic chemistry starts like it ("BR1", "Cl1", "ZN", "FE2"). Returns 0 for no element
/// (a virtual site, a bead of a coarse model) and for unknown names.
std::uint8_t guess_element(const AtomName& atom);

/// Returns true if such a name, which has fewer than four characters and starts in column 13 of
/// PDB, shows that the file does not reserve that column for symbols of two letters ("CA  ALA", "C1
/// LIG").
bool shows_flush_left(std::string_view residue, std::string_view name);

/// Returns the atomic numbers for masses in unified atomic mass units; 0: no element. Masses are
/// those of IUPAC, "Standard atomic weights of the elements 2021", as programs round them. Returns
/// only 0 if no mass belongs to an element beyond helium: such files use reduced units, with masses
/// of 1.
std::vector<std::uint8_t> elements_of_masses(const std::vector<double>& masses);

/// Returns the note that masses told the elements of `count` particles.
ParticleNote masses_note(std::uint64_t count);

/// Gives particles without elements those of the masses of their types, with a note. `masses` has
/// an entry for each of particles.types.names; NaN: unknown.
void take_elements_of_masses(const std::vector<double>& masses, Particles& particles);

}  // namespace parray::input
