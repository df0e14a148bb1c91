#pragma once

#include <cstdint>
#include <optional>
#include <string_view>
#include <vector>

#include "cli/input/particles/file_place.h"
#include "cli/input/particles/particles.h"

/// Bonds in the text of files.
namespace parray::input {

/// Parses the numbers of two bonded atoms, from 1 to `atoms`. The result counts atoms from 0.
/// Throws InputError at `place` for other numbers and texts, and for a bond of an atom to itself.
StatedBond bond_field(std::string_view one, std::string_view other, std::uint64_t atoms,
                      const FilePlace& place);

/// Returns the note that `count` bonds were left out, because each needs two different atoms that
/// the file has exactly once.
ParticleNote unknown_bonds_note(std::uint64_t count);

/// The numbers that a file gives to its atoms. Takes little memory if most atoms have the number
/// after that of the atom before.
class AtomNumbers {
 public:
  /// Adds the number of the next atom; nothing: it has none. Atoms have the indices 0, 1, 2 ... in
  /// the order of these calls. add() may be called again after find().
  void add(std::optional<std::int64_t> number);
  /// Returns the index of the atom with this number. Returns nothing if no atom has it, or several
  /// have it.
  [[nodiscard]] std::optional<std::uint32_t> find(std::int64_t number);
  /// Parses two numbers and returns the bond between the indices of their atoms. Throws InputError
  /// at `place` for a number that no atom or several atoms have, and for a bond of an atom to
  /// itself.
  StatedBond bond(std::string_view one, std::string_view other, const FilePlace& place);

 private:
  /// Atoms whose numbers ascend in steps of 1.
  struct Run {
    std::int64_t number = 0;  ///< of the first atom
    std::uint32_t place = 0;  ///< index of the first atom
    std::uint32_t count = 0;
    std::int64_t end_so_far = 0;  ///< after the largest number of this and the runs before

    [[nodiscard]] std::int64_t end() const { return number + count; }
  };

  void sort_runs();

  std::vector<Run> runs_;
  std::uint32_t atoms_ = 0;
  bool sorted_ = false;
};

}  // namespace parray::input
