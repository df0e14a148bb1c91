#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "cli/input/particles/particles.h"

namespace parray::input {

/// What is known of an atom if its file does not give the element.
struct AtomName {
  std::string_view residue;  ///< "ALA"; empty: unknown
  std::string_view name;     ///< "CA"
  bool two_letters = false;  ///< PDB: the columns indicate a two-letter symbol
  bool in_molecule = true;   ///< false: a site label of a crystal, in which Ca is calcium
};

/// Guesses the element from residue and name, as other programs do. CA of an amino acid is carbon,
/// CA in a residue CA is calcium, HG is hydrogen. CLA of the residue CLA is chlorine, "1HB2" is
/// hydrogen. A two-letter symbol counts if the ion or the columns indicate it, or if no organic
/// atom name starts with it ("BR1", "Cl1", "ZN", "FE2"). Returns 0 for unknown names and for points
/// without an element (a virtual site, a bead of a coarse model).
std::uint8_t guess_element(const AtomName& atom);

/// Returns the element of a name whose columns in PDB indicate a two-letter symbol with a small
/// second letter: "Pt", "Cl2". Returns 0 for other names.
std::uint8_t element_of_columns(const AtomName& atom);

/// Returns true if a name that starts in column 13 of PDB shows that its file does not reserve this
/// column for two-letter symbols ("CA  ALA", "C1  LIG"). Names of four or more characters show
/// nothing.
bool shows_flush_left(std::string_view residue, std::string_view name);

/// Returns an atomic number for each mass in unified atomic mass units. 0: no element. The masses
/// are those of IUPAC, "Standard atomic weights of the elements 2021", rounded as programs do.
/// Returns only 0 if no mass belongs to an element beyond helium, because such files use reduced
/// units with masses of 1.
std::vector<std::uint8_t> elements_of_masses(const std::vector<double>& masses);

/// Returns the note on the elements of `count` particles. `how`: "guessed from masses".
ParticleNote guessed_elements_note(std::uint64_t count, const std::string& how);

/// Returns the note that the elements of `count` particles are unknown.
ParticleNote unknown_elements_note(std::uint64_t count);

/// If `particles` has types but no column of elements, makes the column from the masses of types,
/// and adds notes. Does nothing if no mass matches. `masses` has an entry for each of
/// particles.types.names. NaN: unknown.
void take_elements_of_masses(const std::vector<double>& masses, Particles& particles);

}  // namespace parray::input
