#pragma once

#include <string>
#include <string_view>

#include "cli/input/formats/atom_columns.h"
#include "cli/input/particles/file_place.h"
#include "common/base/text.h"

namespace parray::input {

/// The content of an ATOM or HETATM line in PDB, PDBQT or PQR. Readers use one object for all
/// lines. Its texts refer to the line or to `aligned`. `type` is AutoDock's, only in PDBQT. A
/// number is not_known if the line lacks it, also the occupancy.
struct AtomRecord : Atom {
  double b_factor = not_known;  ///< angstrom^2
  double charge = not_known;    ///< elementary charges: formal in PDB, partial in the others
  double radius = not_known;    ///< angstrom; only in PQR
  std::string aligned{};        ///< the line with its columns aligned, if they were not
};

/// Returns columns `first` to `last`, counted from 1, without blanks at the ends.
inline std::string_view record_field(std::string_view line, std::size_t first, std::size_t last) {
  return field_at(line, first - 1, last - first + 1);
}
/// Returns whether the line begins with `name`. `name` is in capitals; the line may have any letter
/// case.
bool is_record(std::string_view line, std::string_view name);
/// Returns whether the line begins with "HETATM", or with "ATOM" before a blank or a digit, in any
/// letter case, and has at least seven characters.
bool is_atom_record(std::string_view line);

/// Reads a PDB record by columns: "Atomic Coordinate Entry Format Description" 3.3
/// (wwpdb.org/documentation/file-format), section 9. If columns 77 and 78 have no element, a single
/// letter in column 14 is the element. Also accepts these common deviations:
/// - residue names of four letters in columns 18 to 21 (CHARMM, VMD), or in 17 to 20 if the line
///   has no alternative location; chain names of two letters in columns 21 and 22;
/// - columns 73 to 76 as the chain if column 22 is blank (CHARMM's segments);
/// - residue numbers as hybrid-36 (cci.lbl.gov/hybrid_36), in hexadecimal, or missing ("****": 0);
/// - serial numbers of more than five digits, which shift the line, and tabs (eight columns);
/// - lines with blanks between fields, as in PQR, if columns 31 to 54 do not contain three numbers;
///   occupancy and temperature factor must follow the position.
///
/// Throws InputError at `place` for lines without a position or with a zero byte.
void read_pdb_record(std::string_view line, const FilePlace& place, AtomRecord& record);

/// Reads a PDBQT record (AutoDock 4.2 User Guide): PDB with the partial charge in columns 67 to 76.
/// AutoDock's atom type begins in column 78 and gives the element. Throws the errors of
/// read_pdb_record().
void read_pdbqt_record(std::string_view line, const FilePlace& place, AtomRecord& record);

/// Reads a PQR record ("PQR molecular structure format", pdb2pqr.readthedocs.io). Blanks separate
/// the fields: serial, name, residue, chain (optional), residue number, x, y, z, charge, radius. If
/// blanks are missing, the columns of PDB separate the fields up to z. Throws InputError at `place`
/// for lines without position, charge and radius.
void read_pqr_record(std::string_view line, const FilePlace& place, AtomRecord& record);

}  // namespace parray::input
