#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

#include "common/rooms.h"

/// Names of residues and atoms in molecular simulation and crystallography, in any letter case. All
/// functions except residue_group() ignore blanks.
/// Sources:
///
/// - wwPDB Chemical Component Dictionary (wwpdb.org/data/ccd), PDB file format 3.3: HOH, DOD, ALA,
/// MSE;
/// - CHARMM topologies 22 to 36 (mackerell.umaryland.edu/charmm_ff.shtml): TIP3, HSD, ADE, SOD,
/// CLA;
/// - AMBER Reference Manual, chapters on residues and ions: WAT, HIE, CYX, NALA, DA5, Na+, EPW;
/// - GROMACS Reference Manual, "Residue database", "Virtual interaction sites": SOL, MW, MCH3;
/// - OPLS-AA and GROMOS, for names that differ: T4P, CYSH, LYSH.
namespace parray::input {

/// Returns true for the names of water, such as "HOH", "SOL" and "TIP3", also for water models with
/// virtual sites.
bool is_water(std::string_view residue);

/// Returns true for amino acids, their protonation states, common modifications and the caps of
/// chains. Also accepts AMBER's names at chain ends: N or C before a name of three letters.
bool is_amino_acid(std::string_view residue);

/// Returns true for nucleotides of DNA and RNA and common modifications. Also accepts AMBER's names
/// with 5, 3 or N at the end.
bool is_nucleotide(std::string_view residue);

/// Returns the element of a monatomic ion with this atom or residue name: 11 for "SOD", "NA+" and
/// "Na". Returns 0 for other names.
std::uint8_t ion_element(std::string_view name);

/// Returns true for a monatomic ion: both names are those of the same ion, or the residue is "ION",
/// whatever the atom's name. The residue's name alone does not suffice, because "CLA" may be a
/// chlorophyll.
bool is_ion(std::string_view residue, std::string_view atom);

/// Returns true for points that carry charge or constrain motion but are not atoms. Examples are
/// the fourth and fifth sites of water (MW, EPW, OM, LP1), lone pairs, massless sites of rigid
/// groups and dummy atoms. `element` comes from the file; 0 if the file gives none. Outside water
/// and the residue DUM, a point with a known element is an atom.
bool is_virtual_site(std::string_view residue, std::string_view atom, std::uint8_t element);

/// Returns the names of residue groups, such as "polar", "positive", "adenine" and "water". Group i
/// has the colour category_color(i) (particle_colors.h).
std::span<const std::string_view> residue_groups();

/// Returns the place of a residue's group in residue_groups(). Returns nothing for residues of no
/// group.
std::optional<std::size_t> residue_group(std::string_view residue_name);

}  // namespace parray::input
