#pragma once

#include <cstdint>
#include <string_view>
#include <utility>
#include <vector>

#include "cli/input/formats/atom_columns.h"
#include "cli/input/formats/bond_fields.h"

namespace parray::input {

/// Reads the bonds of PDB's CONECT records ("Atomic Coordinate Entry Format Description" 3.3,
/// section 10). Files list most bonds twice, once for each atom, and double bonds more often.
/// Serial numbers may be hexadecimal or hybrid-36.
class ConectBonds {
 public:
  /// Records the serial number in the ATOM or HETATM record of the next atom.
  void add_atom(std::string_view record);
  /// Reads a CONECT record: the serial number of an atom in columns 7 to 11, and those of up to
  /// four bonded atoms in columns of the same width. Blanks separate numbers outside these columns.
  void read(std::string_view record);
  [[nodiscard]] bool empty() const { return pairs_.empty(); }
  /// Replaces the bonds by those of `other`. Keeps the atoms.
  void take_bonds(const ConectBonds& other) { pairs_ = other.pairs_; }
  /// Adds the bonds to `atoms`, which were added in the order of add_atom(). Then forgets bonds and
  /// atoms. Leaves out bonds of an atom to itself, and bonds whose serial numbers no atom has, or
  /// several atoms have. A note counts them.
  void finish(AtomColumns& atoms);
  /// Forgets bonds and atoms.
  void clear();

 private:
  AtomNumbers serials_;
  std::vector<std::pair<std::int64_t, std::int64_t>> pairs_;
};

}  // namespace parray::input
