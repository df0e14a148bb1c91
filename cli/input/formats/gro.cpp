#include <algorithm>
#include <array>
#include <optional>
#include <string>
#include <vector>

#include "cli/input/formats/atom_columns.h"
#include "cli/input/formats/format_table.h"
#include "cli/input/particles/cell.h"
#include "cli/input/particles/particle_input.h"
#include "common/base/text.h"

namespace parray::input {
namespace {

constexpr std::size_t least_line_bytes = 25;
constexpr std::size_t numbers_start = 20;  // after the numbers and names of residue and atom

/// Returns the width of each number in a row: the distance of the decimal points, for any
/// precision. Returns 0 if there are no two points.
std::size_t width_of(std::string_view line) {
  const std::size_t first = line.find('.', numbers_start);
  const std::size_t second = first == std::string_view::npos ? first : line.find('.', first + 1);
  return second == std::string_view::npos ? 0 : second - first;
}

/// Recognises GRO (GROMACS reference manual, "File formats").
Confidence looks_like_gro(const FileStart& start) {
  const std::string_view atom = start.line(2);
  const std::size_t width = width_of(atom);
  if (!is_natural(trimmed(start.line(1))) || !is_natural(field_at(atom, 0, 5)) || width == 0) {
    return Confidence::none;
  }
  for (std::size_t i = 0; i < 3; ++i) {
    if (!is_number(field_at(atom, numbers_start + i * width, width))) return Confidence::none;
  }
  return Confidence::likely;
}

/// Returns the number after "t=" in the title, in picoseconds.
std::optional<double> time_in(std::string_view title) {
  const std::size_t at = title.rfind("t=");
  if (at == std::string_view::npos) return {};
  const std::vector<std::string_view> words = words_of(title.substr(at + 2));
  return words.empty() ? std::nullopt : number_in(words[0]);
}

/// Splits numbers of equal precision that may have no blanks between them. Each has as many digits
/// after its decimal point as the last one.
std::vector<std::string_view> equal_numbers(std::string_view line) {
  std::vector<std::string_view> numbers;
  const std::size_t digits = line.size() - std::min(line.rfind('.'), line.size());
  while (!line.empty()) {
    const std::size_t point = std::min(line.find('.'), line.size());
    const std::size_t end = std::min(point + digits, line.size());
    if (end == 0) break;
    numbers.push_back(trimmed(line.substr(0, end)));
    line.remove_prefix(end);
  }
  return numbers;
}

/// Parses the box of the last line: three lengths, or v1(x) v2(y) v3(z) v1(y) v1(z) v2(x) v2(z)
/// v3(x) v3(y).
std::optional<ParticleCell> gro_box_in(std::string_view line, const FilePlace& place) {
  constexpr std::size_t all = 9;
  std::vector<std::string_view> words = words_of(line);
  if (words.size() == 1) words = equal_numbers(trimmed(line));
  std::array<double, all> v{};
  if (words.size() != 3 && words.size() < all) {
    place.fail(std::to_string(words.size()) +
               " numbers describe the box, but 3 or 9 are needed: check the number of atoms in the "
               "frame's second line, and that the file is complete");
  }
  for (std::size_t i = 0; i < std::min(words.size(), all); ++i) {
    v[i] = angstrom_per_nm * number_field(words[i], "the box", place);
  }
  return valid_cell({{}, {Vec3d{v[0], v[3], v[4]}, {v[5], v[1], v[6]}, {v[7], v[8], v[2]}}});
}

class GroFrames final : public FramesOf<ParticleInput> {
 public:
  using FramesOf::FramesOf;

  bool next() override {
    bool blank = false;
    for (;;) {
      if (!input_.next_line()) return false;
      if (!trimmed(input_.line()).empty()) break;
      blank = true;
    }
    title_ = input_.line();
    const auto count = natural_in(trimmed(title_));
    if (blank && count) {  // the title was the blank line
      count_ = count_field(trimmed(title_), input_.place());
      return true;
    }
    if (!input_.next_line()) input_.fail_incomplete("the file ends after its title");
    count_ = count_field(trimmed(input_.line()), input_.place());
    return true;
  }

  std::uint64_t skip() override {
    for (std::uint64_t i = 0; i <= count_; ++i) go_on(i);
    return count_;
  }

  Particles read() override {
    AtomColumns atoms(input_.place(), request_, {"vx", "vy", "vz"});
    atoms.expect(std::min(count_, input_.bytes_left().value_or(0) / least_line_bytes + 1));
    std::size_t width = 0;
    for (std::uint64_t i = 0; i < count_; ++i) {
      go_on(i);
      if (i == 0) width = width_of(input_.line());
      if (width == 0) {
        input_.fail(
            "the row has no two decimal points from column 21 on: write x, y and z there with "
            "decimal points");
      }
      add_row(input_.line(), width, atoms);
    }
    go_on(count_);
    const auto cell = gro_box_in(input_.line(), input_.place());
    atoms.note(nm_note(count_));
    Particles particles = atoms.finish_frame();
    particles.cell = cell;
    particles.facts.time = time_in(title_);
    return particles;
  }

 private:
  void go_on(std::uint64_t done) { input_.next_row(done, count_, "atoms and the box"); }

  void add_row(std::string_view line, std::size_t width, AtomColumns& atoms) const {
    const auto number = [&](std::size_t i) {
      return field_at(line, numbers_start + i * width, width);
    };
    const auto coordinate = [&](std::size_t i, const char* name) {
      return angstrom_per_nm * number_field(number(i), name, input_.place());
    };
    if (line.size() <= numbers_start + 2 * width) {
      input_.fail(
          "the line ends before the z of an atom: check the number of atoms in the frame's second "
          "line");
    }
    Atom atom;
    atom.residue_number = residue_number_in(field_at(line, 0, 5)).value_or(0);
    atom.residue_name = field_at(line, 5, 5);
    atom.name = field_at(line, 10, 5);
    const double x = coordinate(0, "x");
    const double y = coordinate(1, "y");
    atom.position = {x, y, coordinate(2, "z")};
    atoms.add(atom);
    std::array<double, 3> velocity{};
    for (std::size_t i = 0; i < velocity.size(); ++i) {
      velocity[i] = angstrom_per_nm * number_or_nan(number(3 + i));
    }
    atoms.numbers(velocity);
  }

  std::string title_;
  std::uint64_t count_ = 0;
};

}  // namespace

/// Reads GRO of GROMACS (manual.gromacs.org, "gro") in any precision, with several frames. Converts
/// positions from nm to angstrom, so that van der Waals radii fit. Converts velocities (vx, vy, vz)
/// to angstrom per picosecond. The box becomes the cell. "t=" in the title is the time.
constinit const ParticleFormat gro_format =
    frames_in_angstrom<GroFrames>("GRO", {".gro"}, looks_like_gro);

}  // namespace parray::input
