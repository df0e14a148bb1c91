#pragma once

#include <string_view>
#include <vector>

#include "cli/input/particles/file_place.h"
#include "cli/input/particles/name_index.h"
#include "cli/input/particles/particles.h"

namespace parray::input {

/// An atom of a file that has names but no positions.
struct NamedAtom {
  std::string_view name{};
  std::string_view type{};
  std::string_view residue_name{};
  std::string_view chain{};
  std::int32_t residue_number = 0;
  double charge = 0;  ///< elementary charges; NaN: not known
  double mass = 0;    ///< atomic mass units; NaN: not known
};

/// Collects them.
class NameTable {
 public:
  /// `place` is where the reader stands; it must outlive this.
  explicit NameTable(const FilePlace& place) : place_(place) {}

  void add(const NamedAtom& atom);
  /// With elements by mass or, where that tells none, by name, unless the file says them itself;
  /// the number columns charge and mass where the request wants them. All positions are 0. Fails
  /// when there is no atom.
  Particles finish(const ParticleRequest& request, std::vector<std::uint8_t> elements = {});

 private:
  std::vector<std::uint8_t> guessed_elements(ParticleFacts& facts) const;

  const FilePlace& place_;
  NameIndex names_;
  NameIndex types_;
  NameIndex residues_;
  NameIndex chains_;
  std::vector<std::int32_t> residue_numbers_;
  std::vector<double> charges_;
  std::vector<double> masses_;
};

}  // namespace parray::input
