#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "cli/input/formats/alternative_locations.h"
#include "cli/input/particles/name_index.h"
#include "cli/input/particles/particle_columns.h"

namespace parray::input {

/// An atom as a file of molecules says it. The texts need not outlive the call that takes them.
struct Atom {
  Vec3d position;
  std::string_view name{};
  std::string_view residue_name{};
  std::string_view chain{};
  std::int32_t residue_number = 0;
  char insertion = ' ';
  char alternative = ' ';             ///< location; blank: none
  bool doubtful_alternative = false;  ///< it may be the first letter of the residue's name
  bool two_letters = false;           ///< the columns say so of the symbol in the name
  double occupancy = 1;               ///< NaN: not known
  std::optional<std::uint8_t>
      element{};            ///< 0: the file says that it is none; nothing: to be guessed
  std::string_view type{};  ///< none: the element's symbol
};

/// Collects the atoms of a frame. What the file leaves open is decided at its end: elements by
/// residue and name, and which of the alternative locations stay; notes say how many.
class AtomColumns {
 public:
  /// Of the numbers called `names`, those that the request wants become columns. `place` is where
  /// the reader stands; it must outlive this.
  AtomColumns(const FilePlace& place, const ParticleRequest& request,
              std::initializer_list<const char*> names = {});

  /// Elements that the file says are mended where they cannot be: of CA in ALA, "Ca".
  void doubt_elements() { doubt_elements_ = true; }
  /// Room for so many, of which the reader knows that the file can hold them.
  void expect(std::uint64_t count) { columns_.expect(count); }
  void add(const Atom& atom);
  /// Of the atom just added: its numbers, in the order of the names; NaN: not known.
  void numbers(std::span<const double> values);
  /// Of the atom just added; 0, which programs write of what has none, becomes the element's.
  void radius(double radius);
  void note(std::string key, std::uint64_t count, std::string text);

  [[nodiscard]] std::size_t count() const { return columns_.count(); }

  /// The atoms of a frame, which may be none.
  Particles finish_frame();
  /// Fails when there is none.
  Particles finish();

 private:
  void guess_elements();
  void mend_elements();
  void name_types();
  void fill_radii(Particles& particles) const;
  Particles complete(Particles particles);

  const FilePlace* place_;
  AlternativeChoice choice_;
  ParticleColumns columns_;
  std::vector<std::uint8_t> elements_;
  NameIndex atom_names_;
  NameIndex residue_names_;
  NameIndex chains_;
  NameIndex types_;
  bool own_types_ = false;
  bool flush_left_ = false;
  bool doubt_elements_ = false;
  std::vector<std::int32_t> residue_numbers_;
  std::vector<std::uint8_t> two_letters_;  // by particle, up to the last that has them
  AlternativeColumns alternatives_;
  std::vector<std::optional<std::size_t>> number_columns_;  // by the names' order
  std::vector<std::size_t> without_radius_;
  std::vector<ParticleNote> notes_;
};

}  // namespace parray::input
