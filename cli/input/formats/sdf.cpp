#include <algorithm>
#include <array>
#include <string>
#include <utility>
#include <vector>

#include "cli/input/formats/atom_columns.h"
#include "cli/input/formats/bond_fields.h"
#include "cli/input/formats/format_table.h"
#include "cli/input/particles/elements.h"
#include "cli/input/particles/particle_input.h"
#include "common/base/text.h"

namespace parray::input {
namespace {

Confidence looks_like_sdf(const FileStart& start) {
  const std::string_view counts = trimmed(start.line(3));
  return certain_if(counts.ends_with("V2000") || counts.ends_with("V3000") ||
                    start.has_line("M  END"));
}

bool ends_molecule(std::string_view line) { return line.starts_with("$$$$"); }

/// A line in the atom block of V2000.
struct TableRow {
  Vec3d position;
  std::string_view symbol;
  double charge = 0;
};

/// Returns the charge for its code. Code 4 is a radical.
double charge_of_code(std::string_view code) {
  constexpr std::array<double, 8> charges{0, 3, 2, 1, 0, -1, -2, -3};
  const auto number = natural_in(code).value_or(0);
  return number < charges.size() ? charges[number] : 0;
}

/// Reads a line by columns, or by blanks if its columns are not valid.
TableRow table_row(std::string_view line, const FilePlace& place) {
  constexpr std::size_t width = 10;
  const auto x = number_in(field_at(line, 0, width));
  const auto y = number_in(field_at(line, width, width));
  const auto z = number_in(field_at(line, 2 * width, width));
  const std::string_view symbol = field_at(line, 31, 3);
  if (x && y && z && !symbol.empty()) {
    return {{*x, *y, *z}, symbol, charge_of_code(field_at(line, 36, 3))};
  }
  const std::vector<std::string_view> words = words_of(line);
  if (words.size() < 4 || is_number(words[3])) {  // a number: the line is a bond
    place.fail(
        "the line needs x, y, z and a symbol: check the number of atoms in the molecule's fourth "
        "line");
  }
  return {position_field(words, 0, place), words[3],
          words.size() > 5 ? charge_of_code(words[5]) : 0};
}

/// Reads the molecules one by one. Each has its own header.
class SdfFrames final : public FramesOf<ParticleInput> {
 public:
  using FramesOf::FramesOf;

  bool next() override {
    if (!read_header()) return false;
    const std::string_view counts = input_.line();
    extended_ = counts.find("V3000") != std::string_view::npos;
    atoms_ = extended_ ? 0 : count_field(field_at(counts, 0, 3), input_.place());
    bonds_ = extended_ ? 0 : natural_in(field_at(counts, 3, 3)).value_or(0);
    if (extended_) find_extended_count();
    return true;
  }

  std::uint64_t skip() override {
    go_to_end();
    return atoms_;
  }

  Particles read() override {
    AtomColumns atoms(input_.place(), request_, {"charge"});
    atoms.states_all_bonds();
    constexpr std::size_t row_bytes = 8;  // at least
    atoms.expect(std::min(atoms_, input_.bytes_left().value_or(0) / row_bytes + 1));
    charges_.clear();
    if (extended_) {
      read_extended(atoms);
    } else {
      for (std::uint64_t i = 0; i < atoms_; ++i) {
        go_on();
        const TableRow row = table_row(input_.line(), input_.place());
        add(row.position, row.symbol, row.charge, atoms);
      }
      for (std::uint64_t i = 0; i < bonds_; ++i) {
        go_on();
        const std::string_view line = input_.line();
        atoms.bond(bond_field(field_at(line, 0, 3), field_at(line, 3, 3), atoms_, input_.place()));
      }
    }
    go_to_end();
    for (const double charge : charges_) atoms.numbers({{charge}});
    return atoms.finish_frame();
  }

 private:
  /// Goes to the line of counts, the fourth. Returns false if only blank lines are left.
  bool read_header() {
    bool blank = true;
    for (int line = 0; line < 4; ++line) {
      if (!input_.next_line()) {
        if (blank) return false;
        input_.fail_incomplete("the file ends within a molecule's header");
      }
      blank = blank && trimmed(input_.line()).empty();
    }
    while (blank) {  // the file ends with more blank lines than a header has
      if (!input_.next_line()) return false;
      blank = trimmed(input_.line()).empty();
    }
    return true;
  }

  void go_on() {
    if (!input_.next_line()) input_.fail_incomplete("the file ends within a molecule");
    if (!ends_molecule(input_.line())) return;
    if (atoms_ + bonds_ == 0) input_.fail_incomplete("the molecule has no line 'M  V30 COUNTS'");
    input_.fail("the molecule ends before its " + std::to_string(atoms_) + " atoms and " +
                std::to_string(bonds_) + " bonds: check these numbers");
  }

  /// Reads the words of a line "M  V30 ..." and of its continuation lines.
  void next_extended() {
    go_on();
    text_ = input_.line();
    while (text_.ends_with('-')) {
      text_.pop_back();
      go_on();
      text_ += field_at(input_.line(), 7, std::string::npos);
    }
    split_at_blanks(text_, words_);
    if (words_.size() < 2 || words_[0] != "M" || words_[1] != "V30") words_.clear();
  }

  void find_extended_count() {
    do {
      next_extended();
    } while (words_.size() < 4 || words_[2] != "COUNTS");
    atoms_ = count_field(words_[3], input_.place());
    bonds_ = words_.size() > 4 ? natural_in(words_[4]).value_or(0) : 0;
  }

  /// Goes to the line "M  V30 BEGIN BLOCK".
  void find_block(std::string_view block) {
    do {
      next_extended();
    } while (words_.size() < 4 || words_[2] != "BEGIN" || words_[3] != block);
  }

  void read_extended(AtomColumns& atoms) {
    if (atoms_ == 0) return;
    AtomNumbers numbers;
    find_block("ATOM");
    for (std::uint64_t i = 0; i < atoms_; ++i) {
      constexpr std::size_t least = 7;  // M V30 index type x y z
      next_extended();
      if (words_.size() < least) {
        input_.fail(
            "the line is no 'M  V30 INDEX TYPE X Y Z ...': correct it, or the number of atoms in "
            "the line 'M  V30 COUNTS'");
      }
      add(position_field(words_, 4, input_.place()), words_[3], extended_charge(), atoms);
      numbers.add(parsed<std::int64_t>(words_[2]));
    }
    if (bonds_ > 0) find_block("BOND");
    for (std::uint64_t i = 0; i < bonds_; ++i) {
      next_extended();
      if (words_.size() < 6) {  // M V30 index type atom atom
        input_.fail(
            "the line is no 'M  V30 INDEX TYPE ATOM ATOM': correct it, or the number of bonds in "
            "the line 'M  V30 COUNTS'");
      }
      atoms.bond(numbers.bond(words_[4], words_[5], input_.place()));
    }
  }

  [[nodiscard]] double extended_charge() const {
    constexpr std::string_view key = "CHG=";
    for (const std::string_view word : words_) {
      if (word.starts_with(key)) return number_in(word.substr(key.size())).value_or(0);
    }
    return 0;
  }

  void add(const Vec3d& position, std::string_view symbol, double charge, AtomColumns& atoms) {
    Atom atom;
    atom.position = position;
    atom.name = atom.type = symbol;
    atom.element = atomic_number_of(symbol);
    atoms.add(atom);
    charges_.push_back(charge);
  }

  /// Reads "M  CHG": pairs of an atom's number and its charge. They replace the charges of the atom
  /// block.
  void read_charges(std::string_view line) {
    split_at_blanks(line, words_);
    if (!std::exchange(charges_listed_, true)) std::ranges::fill(charges_, 0.0);
    for (std::size_t i = 3; i + 1 < words_.size(); i += 2) {
      const std::uint64_t atom = natural_in(words_[i]).value_or(0);
      if (atom == 0 || atom > charges_.size()) continue;
      charges_[static_cast<std::size_t>(atom) - 1] = number_in(words_[i + 1]).value_or(0);
    }
  }

  void go_to_end() {
    charges_listed_ = false;
    while (input_.next_line() && !ends_molecule(input_.line())) {
      if (input_.line().starts_with("M  CHG")) read_charges(input_.line());
    }
  }

  bool extended_ = false;
  bool charges_listed_ = false;
  std::uint64_t atoms_ = 0;
  std::uint64_t bonds_ = 0;
  std::vector<double> charges_;
  std::string text_;
  std::vector<std::string_view> words_;
};

}  // namespace

/// Reads MOL and SDF, V2000 and V3000 ("CTfile Formats", BIOVIA, 2020). The molecules of an SDF are
/// its frames. Names and types are the symbols. Numbers: charge (formal).
constinit const ParticleFormat sdf_format =
    frames_in_angstrom<SdfFrames>("SDF", {".sdf", ".mol", ".sd"}, looks_like_sdf);

}  // namespace parray::input
