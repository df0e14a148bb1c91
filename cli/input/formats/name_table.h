#pragma once

#include <vector>

#include "cli/input/formats/atom_columns.h"
#include "cli/input/particles/file_place.h"
#include "cli/input/particles/particle_columns.h"
#include "cli/input/particles/particles.h"

namespace parray::input {

/// Collects the atoms of a topology file.
class NameTable {
 public:
  /// `place` is the position of the reader and must outlive this object.
  explicit NameTable(const FilePlace& place) : place_(place) {}

  /// Adds an atom by its names, numbers and type. `charge`: elementary charges; NaN: not known.
  /// `mass`: atomic mass units; NaN: not known.
  void add(const Atom& atom, double charge, double mass);
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
  SparseColumn<char> insertions_{' '};
  std::vector<double> charges_;
  std::vector<double> masses_;
};

}  // namespace parray::input
