#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "cli/input/particles/particle_columns.h"

namespace parray::input {

/// Stands for a number that a file does not give.
inline constexpr double not_known = std::numeric_limits<double>::quiet_NaN();

/// An atom of a molecule file. The texts must stay valid only during the call of
/// AtomColumns::add().
struct Atom {
  Vec3d position;
  std::string_view name{};
  std::string_view residue_name{};
  std::string_view chain{};
  std::int32_t residue_number = 0;
  char insertion = ' ';
  char alternative = ' ';                 ///< letter of the alternative location; blank: none
  bool doubtful_alternative = false;      ///< the letter may belong to the residue's name
  bool two_letters = false;               ///< columns say that the symbol has two letters
  double occupancy = 1;                   ///< NaN: not known
  std::optional<std::uint8_t> element{};  ///< 0: no element; nothing: guess it
  std::string_view type{};                ///< empty: the element's symbol
};

/// A column whose values are mostly equal. It stores values up to the last unusual one.
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

/// Distinguishes the alternative locations of atoms. Particles are added in their order.
struct AlternativeColumns {
  SparseColumn<char> letters{' '};
  SparseColumn<char> insertions{' '};
  SparseColumn<float> occupancies{1};
  std::vector<std::size_t> doubtful;  ///< particles with doubtful letters
};

/// Collects the atoms of a frame. At the end of the frame it guesses missing elements by residue
/// and name, and chooses among alternative locations. Notes count both.
class AtomColumns {
 public:
  /// `names`: numbers of the format; those that the request wants become columns. `place` is the
  /// position of the reader and must outlive this.
  AtomColumns(const FilePlace& place, const ParticleRequest& request,
              std::initializer_list<const char*> names = {});

  /// Corrects elements of the file that cannot be right, such as "Ca" for CA in ALA.
  void doubt_elements() { doubt_elements_ = true; }
  /// Reserves room for `count` atoms. The reader must know that the file can hold so many.
  void expect(std::uint64_t count) { columns_.expect(count); }
  void add(const Atom& atom);
  /// Sets the numbers of the atom added last, in the order of `names`; NaN: not known.
  void numbers(std::span<const double> values);
  /// Sets the radius of the atom added last. 0 stands for the radius of the element.
  void radius(double radius);
  void note(std::string key, std::uint64_t count, std::string text);

  [[nodiscard]] std::size_t count() const { return columns_.count(); }

  /// Returns the atoms of a frame, which may be empty.
  Particles finish_frame();
  /// Returns the atoms. Fails if there are none.
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

/// Returns the number of a residue: 12, "A000" (hybrid-36: 10000), "27a1" (hexadecimal). Returns
/// nothing for "****" and other texts.
std::optional<std::int32_t> residue_number_in(std::string_view text);

}  // namespace parray::input
