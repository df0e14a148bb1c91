#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <string_view>

#include "cli/input/formats/atom_columns.h"
#include "cli/input/particles/file_place.h"

namespace parray::input {

/// What a line ATOM or HETATM of PDB and its relatives says. Reused from line to line.
struct AtomRecord {
  static constexpr double unknown = std::numeric_limits<double>::quiet_NaN();

  Vec3d position;
  std::string name;
  std::string residue_name;
  std::string chain;
  std::string type;  ///< AutoDock's
  std::int32_t residue_number = 0;
  char insertion = ' ';
  char alternative = ' ';
  bool doubtful_alternative = false;
  bool two_letters = false;
  double occupancy = unknown;
  double b_factor = unknown;
  double charge = unknown;
  double radius = unknown;
  std::optional<std::uint8_t> element;

  [[nodiscard]] Atom atom() const {
    return {position,       name,      residue_name, chain,
            residue_number, insertion, alternative,  doubtful_alternative,
            two_letters,    occupancy, element,      type};
  }
};

/// "ATOM" or "HETATM", whatever the letter case, and a field after it.
bool is_atom_record(std::string_view line);

/// PDB, "Atomic Coordinate Entry Format Description" 3.3 (wwpdb.org/documentation/file-format),
/// section 9, by columns. Beyond the standard:
/// - residue names of four letters in columns 18 to 21 (CHARMM, VMD) or, where no alternative
///   location is meant, 17 to 20; names of chains of two letters in columns 21 and 22;
/// - columns 73 to 76 name the chain where column 22 is blank (CHARMM's segments);
/// - residue numbers as hybrid-36 (cci.lbl.gov/hybrid_36), in hexadecimal, or none ("****": 0);
/// - serial numbers of more than five digits that shift the line, tabs (as eight columns), and
/// lines
///   whose fields blanks separate, as read_pqr_record() takes them, where columns 31 to 54 do not
///   hold three numbers.
void read_pdb_record(std::string_view line, const FilePlace& place, AtomRecord& record);

/// PDBQT, AutoDock 4.2 User Guide: as PDB, with the partial charge in columns 67 to 76 and
/// AutoDock's type of the atom from column 78 on, which tells the element.
void read_pdbqt_record(std::string_view line, const FilePlace& place, AtomRecord& record);

/// PQR, "PQR molecular structure format" (pdb2pqr.readthedocs.io): fields that blanks separate:
/// serial, name, residue, chain (may be missing), residue number, x, y, z, charge, radius; or PDB's
/// columns for all up to z where fields run together.
void read_pqr_record(std::string_view line, const FilePlace& place, AtomRecord& record);

/// The number of a residue as files write it: 12, "A000" (hybrid-36: 10000), "27a1" (hexadecimal);
/// nothing for "****" and other texts.
std::optional<std::int32_t> residue_number_in(std::string_view text);

}  // namespace parray::input
