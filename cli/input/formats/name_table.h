#pragma once

#include <string_view>
#include <vector>

#include "cli/input/particles/file_place.h"
#include "cli/input/particles/particle_columns.h"
#include "cli/input/particles/particles.h"

namespace parray::input {

/// An atom in a file with names but without positions.
struct NamedAtom {
  std::string_view name{};
  std::string_view type{};
  std::string_view residue_name{};
  std::string_view chain{};
  std::int32_t residue_number = 0;
  char insertion = ' ';
  double charge = 0;  ///< elementary charges; NaN: not known
  double mass = 0;    ///< atomic mass units; NaN: not known
};

/// Collects the atoms of a topology file.
class NameTable {
 public:
  /// `place` is the position of the reader and must outlive this object.
  explicit NameTable(const FilePlace& place) : place_(place) {}

  void add(const NamedAtom& atom);
  /// Returns the atoms with all positions 0. `elements`: one atomic number per atom. If it is
  /// empty, the elements come from the masses. An atom whose mass belongs to no element gets its
  /// element from the names, unless its mass is below 1. Notes count these guesses. Adds the
  /// columns charge and mass if the request wants them. Throws InputError at `place` if there are
  /// no atoms.
  Particles finish(const ParticleRequest& request, std::vector<std::uint8_t> elements = {});

 private:
  std::vector<std::uint8_t> guessed_elements(ParticleFacts& facts) const;

  const FilePlace& place_;
  NameIndex names_;
  NameIndex types_;
  NameIndex residues_;
  NameIndex chains_;
  std::vector<std::int32_t> residue_numbers_;
  std::vector<char> insertions_;
  std::vector<double> charges_;
  std::vector<double> masses_;
};

}  // namespace parray::input
