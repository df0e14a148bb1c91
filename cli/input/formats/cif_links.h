#pragma once

#include <array>
#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "cli/input/particles/particles.h"

/// The bonds that CIF states between named atoms: struct_conn of mmCIF, which has links between
/// residues, and chem_comp_bond of components, which has all bonds.
namespace parray::input {

/// One of the two atoms of a bond.
struct CifLinkEnd {
  std::string name;
  std::string chain;
  std::string label_chain;  ///< instead of an empty `chain`
  std::string residue_number;
  std::string label_number = "1";  ///< instead of an empty `residue_number`; 1 in components
  std::string insertion;
  std::string alternative;
  /// The bond ends at the image of the atom under this symmetry operation. "1_555" (in mmCIF): the
  /// atom itself.
  std::string symmetry;
};

/// The tables of bonds in a block.
class CifLinks {
 public:
  /// Returns whether a plain tag (plain_tag() in cif_atoms.h) belongs to a table of bonds.
  static bool is_table(std::string_view plain_tag);

  /// Begins a table with these plain tags, one or more.
  void start(const std::vector<std::string>& tags);
  /// Adds the next value of the table, without quotes.
  void add(std::string value);

  /// Adds bonds to the particles. `component` true: those of chem_comp_bond. False: covalent,
  /// disulfide and metal bonds of struct_conn whose ends have the same symmetry operation. A note
  /// counts the bonds that were left out, because an atom is missing or occurs several times.
  void finish(bool component, Particles& particles) const;

 private:
  struct Column {
    std::string CifLinkEnd::*member = nullptr;
    std::size_t end = 0;
    bool kind = false;  ///< the kind of the bond
  };
  struct Link {
    std::array<CifLinkEnd, 2> ends;
    bool component = false;
    std::string kind;
  };

  static bool is_bond(const Link& link);

  bool component_ = false;       // of the current table
  std::vector<Column> columns_;  // of the current table
  std::size_t next_ = 0;
  std::vector<Link> links_;
};

}  // namespace parray::input
