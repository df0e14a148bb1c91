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
  bool in_molecule = true;   ///< false: a site label of CIF in a crystal, where Ca is calcium
};

/// Guesses the atomic number from residue and name. CA of an amino acid is carbon, CA in a residue
/// CA is calcium. HG of an amino acid and "1HB2" are hydrogen. CLA of the residue CLA is chlorine.
/// In amino acids, nucleotides and water, only selenium has a two-letter symbol. In other residues,
/// a two-letter symbol counts if the residue or a charge shows that ion, or if the columns indicate
/// the symbol. It also counts if no organic atom name starts with it ("BR1", "Cl1", "ZN", "FE2").
/// Returns 0 for unknown names and for points without an element (a virtual site, a bead of a
/// coarse model).
std::uint8_t guess_element(const AtomName& atom);

/// Returns the atomic number of a name whose columns in PDB indicate a two-letter symbol with a
/// lower-case second letter: "Pt", "Cl2". Returns 0 for other names.
std::uint8_t element_of_columns(const AtomName& atom);

/// Call it for each name that starts in column 13 of a PDB file. Returns true if the name shows
/// that the file does not reserve this column for two-letter symbols. Examples are CA in ALA, which
/// is not calcium, and C1 in LIG. Then the columns of the whole file indicate nothing. Names of
/// four or more characters show nothing.
bool shows_flush_left(std::string_view residue, std::string_view name);

/// Returns an atomic number for each mass in unified atomic mass units (u). 0: no element. A mass
/// may differ from the element's weight by 0.015 u, and from 20 u on by 0.03 u, because programs
/// round masses. Weights: IUPAC, "Standard atomic weights of the elements 2021". Deuterium counts
/// as hydrogen. Returns only 0 if no mass belongs to an element beyond helium, because such files
/// use reduced units with masses of 1.
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
