#pragma once

#include <cstdint>
#include <string_view>

#include "common/rooms.h"

/// What the names of residues and atoms of molecules say, whatever their letter case. The names are
/// those that molecular simulation and crystallography use:
///
/// - wwPDB Chemical Component Dictionary (wwpdb.org/data/ccd) and the PDB file format 3.3: HOH,
/// DOD,
///   ALA, MSE, DA, ZN, IOD;
/// - CHARMM topologies 22 to 36 (mackerell.umaryland.edu/charmm_ff.shtml): TIP3, HSD, ADE, SOD,
/// CLA;
/// - AMBER Reference Manual, chapters on residues and ions: WAT, HIE, CYX, NALA, DA5, RU3, Na+,
/// EPW;
/// - GROMACS Reference Manual, "Residue database" and "Virtual interaction sites": SOL, MW, MCH3;
/// - OPLS-AA and GROMOS names where they differ: T4P, CYSH, LYSH.
namespace parray::input {

/// "HOH", "SOL", "TIP3", also of water models with virtual sites.
bool is_water(std::string_view residue);

/// Amino acids, their protonation states, common modifications and the caps of chains. Names of
/// four letters that are one of three with N or C before it (AMBER's ends of chains) count.
bool is_amino_acid(std::string_view residue);

/// Nucleotides of DNA and RNA, also with AMBER's 5, 3 and N behind them, and common modifications.
bool is_nucleotide(std::string_view residue);

/// The element that an ion of this name (of an atom or of its residue) consists of: 11 of "SOD",
/// "NA+" and "Na"; 0: not the name of a monatomic ion.
std::uint8_t ion_element(std::string_view name);

/// A monatomic ion: both names are the ion's ("CLA" is also a chlorophyll), or the residue is
/// "ION".
bool is_ion(std::string_view residue, std::string_view atom);

/// A point that carries charge or constrains motion but is no atom: the fourth and fifth sites of
/// water (MW, EPW, OM, LP1), lone pairs, the massless sites of rigid groups, dummy atoms. `element`
/// is what the file says of it, 0: nothing; outside water an element that is known makes it an
/// atom.
bool is_virtual_site(std::string_view residue, std::string_view atom, std::uint8_t element);

}  // namespace parray::input
