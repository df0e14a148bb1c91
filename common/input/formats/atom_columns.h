#pragma once

#include <cstddef>
#include <string>
#include <unordered_map>

#include "common/input/particles/particle_columns.h"

namespace parray {

/// An atom of a molecular structure.
struct Atom {
  Vec3d position;
  std::uint8_t atomic_number = 0;  ///< 0: unknown
  std::string residue;             ///< chain, number and insertion code
  std::string residue_name;
  std::string name;
  bool alternative_location = false;  ///< one of several
  double occupancy = 1;
};

/// Collects atoms; their types are the elements' symbols. Of an atom's alternative locations one
/// stays, in the place of the first: that of the highest occupancy, the first of equals. Where even
/// the residue is one of two, the first one stays.
class AtomColumns {
 public:
  /// As ParticleColumns.
  explicit AtomColumns(const FilePlace& place) : columns_(place) {}

  void add(const Atom& atom);
  Particles finish() { return columns_.finish(); }

 private:
  struct Kept {
    std::size_t index;
    double occupancy;
  };
  bool is_new(const Atom& atom);

  ParticleColumns columns_;
  // Of atoms with alternative locations only.
  std::unordered_map<std::string, std::string> residue_names_;
  std::unordered_map<std::string, Kept> kept_;
};

}  // namespace parray
