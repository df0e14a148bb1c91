#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <map>
#include <optional>
#include <span>
#include <string_view>
#include <utility>
#include <vector>

#include "cli/input/formats/notes.h"
#include "cli/input/particles/particle_columns.h"

namespace parray::input {

/// Means that a file does not give a number.
inline constexpr double not_known = std::numeric_limits<double>::quiet_NaN();

/// An atom of a molecule file. The texts need to be valid only during the call of
/// AtomColumns::add().
struct Atom {
  Vec3d position;
  std::string_view name{};
  std::string_view residue_name{};
  std::string_view chain{};
  std::int32_t residue_number = 0;
  char insertion = ' ';
  char alternative = ' ';                 ///< letter of the alternative location; blank: none
  bool doubtful_alternative = false;      ///< `alternative` may belong to the residue's name
  bool two_letters = false;               ///< the name seems to begin with a two-letter symbol
  double occupancy = 1;                   ///< NaN: not known
  std::optional<std::uint8_t> element{};  ///< 0: no element; not given: guess it
  /// Type. If it is empty for all atoms of a frame, the types are the symbols of the elements. If
  /// no atom has an element either, they are the names of the atoms.
  std::string_view type{};
};

/// A column in which most values equal `usual`. It stores only the values up to the last one that
/// differs.
template <typename T>
class SparseColumn {
 public:
  explicit SparseColumn(T usual) : usual_(usual) {}

  /// Sets the value of a particle. Call it in the order of the particles.
  void set(std::size_t particle, T value) {
    if (value == usual_) return;
    values_.resize(particle + 1, usual_);
    values_[particle] = value;
  }
  [[nodiscard]] T at(std::size_t particle) const {
    return particle < values_.size() ? values_[particle] : usual_;
  }
  /// Sets the value of a particle back to the usual one. It must differ from the usual one.
  void reset(std::size_t particle) { values_[particle] = usual_; }
  [[nodiscard]] bool empty() const { return values_.empty(); }
  /// Returns the values of `count` particles. Returns none if all values that were set are usual.
  [[nodiscard]] std::vector<T> values(std::size_t count) const {
    std::vector<T> all = values_;
    if (!all.empty()) all.resize(count, usual_);
    return all;
  }

 private:
  T usual_;
  std::vector<T> values_;
};

/// The data that distinguish alternative locations of atoms. Add particles in their order.
struct AlternativeColumns {
  SparseColumn<char> letters{' '};
  SparseColumn<char> insertions{' '};
  SparseColumn<float> occupancies{1};
  std::vector<std::size_t> doubtful;  ///< particles with doubtful letters
};

/// Chooses one value for each key. A value with the wanted letter comes first; if there is none,
/// the value with the highest occupancy does. If several are equal, the first one is chosen.
template <typename Key, typename Value>
class Choices {
 public:
  explicit Choices(const AlternativeChoice& choice) : choice_(choice) {}

  /// `letters`: the letter of an alternative location, or a longer name, which nobody can want.
  void offer(const Key& key, std::string_view letters, double occupancy, const Value& value) {
    const bool wanted = choice_.rule == AlternativeChoice::Rule::letter &&
                        letters == std::string_view(&choice_.letter, 1);
    Offer& best = best_.try_emplace(key, Offer{wanted, occupancy, value}).first->second;
    const bool better = wanted != best.wanted ? wanted : occupancy > best.occupancy;
    if (better) best = {wanted, occupancy, value};
  }
  [[nodiscard]] bool has(const Key& key) const { return best_.contains(key); }
  /// Returns the chosen value of a key that has().
  [[nodiscard]] const Value& of(const Key& key) const { return best_.at(key).value; }

 private:
  struct Offer {
    bool wanted;
    double occupancy;
    Value value;
  };

  AlternativeChoice choice_;
  std::map<Key, Offer> best_;
};

/// Collects the atoms of one frame. At the end of the frame, it guesses missing elements from
/// residue and name, and chooses among alternative locations by ParticleRequest::alternatives.
/// Notes count the guessed elements and the locations that were left out. The last call is
/// finish_frame() or finish().
class AtomColumns {
 public:
  /// `names`: the numeric columns of the format, such as "charge". Those that the request wants
  /// become columns. `place` is the position of the reader and must outlive this object.
  AtomColumns(const FilePlace& place, const ParticleRequest& request,
              std::initializer_list<const char*> names = {});

  /// Makes finish_frame() correct wrong elements of the file, such as "Ca" for CA in ALA.
  void doubt_elements() { doubt_elements_ = true; }
  /// Reserves memory for `count` atoms. Call it only if the file can contain so many atoms.
  void expect(std::uint64_t count) { columns_.expect(count); }
  void add(const Atom& atom);
  /// Sets the numbers of the last atom, in the order of `names`. NaN: not known. Call it after each
  /// add() unless `names` is empty.
  void numbers(std::span<const double> values);
  /// Sets the radius of the last atom. 0 means the van der Waals radius of the element. Call it
  /// after each add(), or never.
  void radius(double radius);
  /// Adds a note, unless its count is 0.
  void note(ParticleNote note) { add_note(notes_, std::move(note)); }
  /// Adds a bond. Atoms count from 0 in the order of add().
  void bond(const StatedBond& bond) { bonds_.push_back(bond); }
  /// Says that the file states all bonds of its atoms, if it states any. Then automatic bonds are
  /// only those of the file, and close atoms get no others.
  void states_all_bonds() { all_bonds_ = true; }

  [[nodiscard]] std::size_t count() const { return columns_.count(); }

  /// Returns the atoms of a frame, which may be empty.
  Particles finish_frame();
  /// Does the same. Throws InputError at `place` if there are no atoms.
  Particles finish();

 private:
  void guess_elements();
  void mend_elements();
  void name_types();
  Particles complete(Particles particles, const ParticleMask& mask);

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
  SparseColumn<std::uint8_t> two_letters_{0};
  AlternativeColumns alternatives_;
  std::vector<std::optional<std::size_t>> number_columns_;  // in the order of `names`
  std::vector<std::size_t> without_radius_;
  std::vector<ParticleNote> notes_;
  std::vector<StatedBond> bonds_;
  bool all_bonds_ = false;
};

/// Types of a force field that belong to one element, separated and enclosed by blanks.
struct TypesOfElement {
  std::string_view types;
  std::uint8_t element = 0;
};
/// Returns the element of a type. Returns nothing for types that are in none of the lists.
std::optional<std::uint8_t> element_of_listed(std::span<const TypesOfElement> lists,
                                              std::string_view type);

/// Parses the number of a residue: "12", "A000" (hybrid-36: 10000), "27a1" (hexadecimal). Returns
/// nothing for texts that are no number, such as "****".
std::optional<std::int32_t> residue_number_in(std::string_view text);

/// Parses the serial number of an atom in the same way. Hybrid-36 has five characters: "A0000" is
/// 100000.
std::optional<std::int64_t> serial_number_in(std::string_view text);

}  // namespace parray::input
