#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "cli/input/particles/alternatives.h"
#include "cli/input/particles/name_index.h"
#include "cli/input/particles/particle_mask.h"

namespace parray::input {

/// A column whose values are mostly the same: it is as long as the last other one needs.
template <typename T>
class SparseColumn {
 public:
  explicit SparseColumn(T usual) : usual_(usual) {}

  void set(std::size_t particle, T value) {
    if (value == usual_) return;
    values_.resize(particle + 1, usual_);
    values_[particle] = value;
  }
  [[nodiscard]] T at(std::size_t particle) const {
    return particle < values_.size() ? values_[particle] : usual_;
  }
  void reset(std::size_t particle) { values_[particle] = usual_; }
  [[nodiscard]] bool empty() const { return values_.empty(); }

 private:
  T usual_;
  std::vector<T> values_;
};

/// What tells the alternative locations of atoms apart. Particles are added in their order.
struct AlternativeColumns {
  SparseColumn<char> letters{' '};
  SparseColumn<char> insertions{' '};
  SparseColumn<float> occupancies{1};
  std::vector<std::size_t> doubtful;  ///< whose letter may start the residue's name
};

/// What else identifies an atom.
struct AtomIdentity {
  NameIndex& residue_names;
  const std::vector<std::uint32_t>& atom_names;  ///< numbers, by particle
  const std::vector<std::uint32_t>& chains;
  const std::vector<std::int32_t>& residue_numbers;
};

/// Where a doubtful letter is the only one in its residue, and the occupancies say nothing of
/// alternatives, it is no letter of a location but the first of the residue's name.
void settle_doubtful(AlternativeColumns& alternatives, const AtomIdentity& atoms);

/// Which atoms stay. Locations of one atom share chain, residue and name, and differ in their
/// letters; atoms that share the letter, too, all stay. Where the residues of the locations differ
/// (a mutant beside the wild type), one residue is chosen first.
ParticleMask chosen_locations(const AlternativeColumns& alternatives, const AtomIdentity& atoms,
                              const AlternativeChoice& choice);

}  // namespace parray::input
