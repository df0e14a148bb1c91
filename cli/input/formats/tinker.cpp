#include <algorithm>
#include <array>
#include <optional>
#include <string>

#include "cli/input/formats/atom_columns.h"
#include "cli/input/formats/bond_fields.h"
#include "cli/input/formats/format_table.h"
#include "cli/input/formats/row_layout.h"
#include "cli/input/particles/cell.h"
#include "cli/input/particles/particle_input.h"
#include "common/base/ascii.h"
#include "common/base/text.h"

namespace parray::input {
namespace {

/// Returns whether a line is a box: three lengths and three angles.
bool is_box_of_tinker(const Fields& words) {
  return words.size() == 6 && std::ranges::all_of(words, is_number);
}

/// Returns whether a line is an atom: number, name, x, y, z, type, then the numbers of the bonded
/// atoms.
bool is_atom_of_tinker(const Fields& words, std::string_view number) {
  return words.size() >= 6 && words[0] == number && !is_number(words[1]) &&
         std::all_of(words.begin() + 2, words.begin() + 5, is_number) && is_natural(words[5]);
}

/// Recognises Tinker (Tinker User's Guide, "File types"): a count and a title, a box or none, atoms
/// numbered from 1.
Confidence looks_like_tinker(const FileStart& start) {
  const Fields head = words_of(start.line(0));
  if (head.empty() || !is_natural(head[0])) return Confidence::none;
  const std::size_t first = is_box_of_tinker(words_of(start.line(1))) ? 2 : 1;
  if (!is_atom_of_tinker(words_of(start.line(first)), "1")) return Confidence::none;
  const Fields second = words_of(start.line(first + 1));
  const bool one = second.empty() || natural_in(head[0]) == 1U;
  return certain_if(one || is_atom_of_tinker(second, "2"));
}

/// Reads the frames one by one. Archives (.arc) have several.
class TinkerFrames final : public FramesOf<ParticleInput> {
 public:
  using FramesOf::FramesOf;

  bool next() override {
    if (!input_.next_filled_line()) return false;
    split_at_blanks(input_.line(), words_);
    count_ = count_field(words_[0], input_.place());
    cell_.reset();
    at_atom_ = false;
    if (count_ > 0) find_box();
    return true;
  }

  std::uint64_t skip() override {
    input_.skip_rows(count_ - (at_atom_ ? 1 : 0));
    return count_;
  }

  Particles read() override {
    AtomColumns atoms(input_.place(), request_);
    atoms.expect(std::min(count_, input_.bytes_left().value_or(0) / least_row_bytes + 1));
    atoms.states_all_bonds();
    for (std::uint64_t i = 0; i < count_; ++i) {
      if (i > 0 || !at_atom_) next_row(i);
      add_atom(atoms);
    }
    Particles particles = atoms.finish_frame();
    particles.cell = cell_;
    return particles;
  }

 private:
  static constexpr std::uint64_t least_row_bytes = 12;  // "1 C 0 0 0 1\n"
  static constexpr std::size_t type_column = 5;

  void next_row(std::uint64_t done) {
    input_.next_row(done, count_, "atoms");
    split_at_blanks(input_.line(), words_);
  }

  /// Reads the line of the box if there is one. Otherwise the line is the first atom.
  void find_box() {
    next_row(0);
    at_atom_ = !is_box_of_tinker(words_);
    if (at_atom_) return;
    std::array<double, 6> values{};
    std::ranges::transform(words_, values.begin(), number_or_nan);
    const auto [a, b, c, alpha, beta, gamma] = values;
    cell_ = cell_from({a, b, c}, {alpha, beta, gamma});
  }

  /// Adds an atom and its bonds. Both atoms of a bond name each other.
  void add_atom(AtomColumns& atoms) const {
    if (words_.size() <= type_column) {
      input_.fail(
          "the line needs number, name, x, y, z and type of an atom: check the number of atoms in "
          "the frame's first line");
    }
    Atom atom;
    atom.name = words_[1];
    atom.position = position_field(words_, 2, input_.place());
    atom.type = words_[type_column];
    // The names of ions and metals have a small second letter.
    atom.two_letters = atom.name.size() > 1 && ascii::is_lower(atom.name[1]);
    atoms.add(atom);
    const std::string number = std::to_string(atoms.count());
    for (std::size_t i = type_column + 1; i < words_.size(); ++i) {
      atoms.bond(bond_field(number, words_[i], count_, input_.place()));
    }
  }

  std::uint64_t count_ = 0;
  bool at_atom_ = false;  // true: the current line is the first atom
  std::optional<ParticleCell> cell_;
  Fields words_;
};

}  // namespace

/// Reads Tinker's coordinates and archives, with or without a box. The names give the elements, and
/// a note says so. Types are the numbers of the force field.
constinit const ParticleFormat tinker_format =
    frames_in_angstrom<TinkerFrames>("Tinker", {".txyz", ".arc"}, looks_like_tinker);

}  // namespace parray::input
