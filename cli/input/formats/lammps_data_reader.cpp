#include <algorithm>
#include <array>
#include <limits>
#include <map>
#include <span>
#include <unordered_map>

#include "cli/input/formats/lammps_styles.h"
#include "cli/input/formats/readers.h"
#include "cli/input/formats/row_layout.h"
#include "cli/input/particles/cell.h"
#include "cli/input/particles/element_mass.h"
#include "cli/input/particles/particle_input.h"
#include "cli/input/particles/particle_text.h"

namespace parray::input {
namespace {

constexpr double unknown_number = std::numeric_limits<double>::quiet_NaN();
constexpr std::array<std::string_view, 30> section_names{"Atoms",
                                                         "Velocities",
                                                         "Masses",
                                                         "Ellipsoids",
                                                         "Lines",
                                                         "Triangles",
                                                         "Bodies",
                                                         "Bonds",
                                                         "Angles",
                                                         "Dihedrals",
                                                         "Impropers",
                                                         "Atom Type Labels",
                                                         "Bond Type Labels",
                                                         "Angle Type Labels",
                                                         "Dihedral Type Labels",
                                                         "Improper Type Labels",
                                                         "Pair Coeffs",
                                                         "PairIJ Coeffs",
                                                         "Bond Coeffs",
                                                         "Angle Coeffs",
                                                         "Dihedral Coeffs",
                                                         "Improper Coeffs",
                                                         "BondBond Coeffs",
                                                         "BondBond13 Coeffs",
                                                         "BondAngle Coeffs",
                                                         "MiddleBondTorsion Coeffs",
                                                         "EndBondTorsion Coeffs",
                                                         "AngleTorsion Coeffs",
                                                         "AngleAngleTorsion Coeffs",
                                                         "AngleAngle Coeffs"};

bool is_section(std::string_view text) {
  const bool letter = !text.empty() && text[0] >= 'A' && text[0] <= 'Z';
  return letter && std::ranges::find(section_names, text) != section_names.end();
}

/// The lines "VALUES KEYWORD" before the first section.
class DataHeader {
 public:
  std::uint64_t atoms = 0;
  std::uint64_t types = 0;

  void read(const Fields& words, const FilePlace& place) {
    std::string line;
    for (const std::string_view word : words) line.append(" ").append(word);
    if (line.ends_with(" atoms")) {
      atoms = count_field(words[0], place);
    } else if (line.ends_with(" atom types")) {
      types = natural_in(words[0]).value_or(0);
    } else if (line.ends_with(" xy xz yz")) {
      take(words, place, tilt_);
    } else if (line.ends_with(" abc origin")) {
      take(words, place, origin_);
    } else {
      read_edge(line, words, place);
    }
  }

  /// LAMMPS manual, "Triclinic (non-orthogonal) simulation boxes".
  [[nodiscard]] std::optional<ParticleCell> cell() const {
    if (general_)
      return valid_cell({vector(origin_), {vector(rows_[0]), vector(rows_[1]), vector(rows_[2])}});
    const auto side = [&](std::size_t i) { return rows_.at(i)[1] - rows_.at(i)[0]; };
    const auto [xy, xz, yz] = tilt_;
    return valid_cell({{rows_[0][0], rows_[1][0], rows_[2][0]},
                       {Vec3d{side(0), 0, 0}, Vec3d{xy, side(1), 0}, Vec3d{xz, yz, side(2)}}});
  }

 private:
  using Three = std::array<double, 3>;

  static Vec3d vector(const Three& three) { return {three[0], three[1], three[2]}; }

  /// Bounds along an axis, or an edge of a general box.
  void read_edge(std::string_view line, const Fields& words, const FilePlace& place) {
    constexpr std::array<std::string_view, 3> bounds{" xlo xhi", " ylo yhi", " zlo zhi"};
    constexpr std::array<std::string_view, 3> edges{" avec", " bvec", " cvec"};
    for (std::size_t i = 0; i < rows_.size(); ++i) {
      if (line.ends_with(bounds.at(i))) take(words, place, std::span(rows_.at(i)).first(2));
      if (!line.ends_with(edges.at(i))) continue;
      take(words, place, rows_.at(i));
      general_ = true;
    }
  }

  static void take(const Fields& words, const FilePlace& place, std::span<double> to) {
    if (words.size() < to.size()) place.fail("too few numbers in the header: is it complete?");
    for (std::size_t i = 0; i < to.size(); ++i) {
      to[i] = number_field(words[i], "number", place);
    }
  }

  std::array<Three, 3> rows_{};  // low and high by axis, or edges
  Three tilt_{};
  Three origin_{};
  bool general_ = false;
};

/// A LAMMPS data file: a comment, a header, then sections, each a keyword and its lines.
class DataFile {
 public:
  DataFile(PackedFile& file, const ParticleRequest& request)
      : request_(request), input_(file), columns_(input_.place()) {}

  Particles read() {
    if (!input_.next_line()) input_.fail("the file is empty: is it complete?");
    std::string section;  // empty: the header
    while (next_line()) {
      if (is_section(text_)) {
        section = text_;
        if (section == "Atoms") read_atoms(std::string(comment_));
      } else if (section.empty()) {
        header_.read(words_, input_.place());
      } else {
        read_line_of(section);
      }
    }
    if (!have_atoms_) input_.fail("no section Atoms: is this a LAMMPS data file?");
    return finish();
  }

 private:
  /// The next line that is more than a comment.
  bool next_line() {
    while (input_.next_line()) {
      const std::string_view line = input_.line();
      const std::size_t mark = std::min(line.find('#'), line.size());
      text_ = trimmed(line.substr(0, mark));
      comment_ = trimmed(line.substr(std::min(mark + 1, line.size())));
      split_at_blanks(text_, words_);
      if (!text_.empty()) return true;
    }
    return false;
  }

  void read_line_of(std::string_view section) {
    if (section == "Atoms") input_.fail("text after the last atom: is the number of atoms right?");
    if (section == "Masses" && words_.size() >= 2) {
      masses_[std::string(words_[0])] = number_or_nan(words_[1]);
    } else if (section == "Velocities" && wants_velocities() && words_.size() >= 4) {
      velocities_[std::string(words_[0])] = {number_or_nan(words_[1]), number_or_nan(words_[2]),
                                             number_or_nan(words_[3])};
    } else if (section == "Atom Type Labels" && words_.size() >= 2) {
      labels_[std::string(words_[0])] = words_[1];
    }
  }

  [[nodiscard]] bool wants_velocities() const {
    return std::ranges::any_of(velocity_names, [&](auto name) { return request_.wants(name); });
  }

  void read_atoms(const std::string& hint) {
    if (have_atoms_) input_.fail("two sections Atoms: remove one");
    have_atoms_ = true;
    columns_.expect(std::min(header_.atoms, input_.bytes_left().value_or(0) / least_row_bytes + 1));
    RowLayout layout;
    std::size_t width = 0;
    for (std::uint64_t i = 0; i < header_.atoms; ++i) {
      if (!next_line() || is_section(text_)) {
        input_.fail("the atoms end after " + std::to_string(i) + " of " +
                    std::to_string(header_.atoms) + ": is the file complete?");
      }
      if (i == 0) {
        const std::vector<std::string> names = names_of_columns(hint);
        width = names.size();
        layout = layout_of(names, input_.place());
        use_diameters(names, layout);
        want_numbers(other_fields(names, layout), request_, layout, columns_);
      }
      if (words_.size() != width && words_.size() != width + image_flags) fail_width(width);
      add_row(words_, layout, input_.place(), columns_);
      if (wants_velocities()) ids_.emplace_back(words_[0]);
    }
  }

  /// By the hint after "Atoms", or else by the first row, which is the current line.
  std::vector<std::string> names_of_columns(const std::string& hint) {
    std::string_view style = std::string_view(hint).substr(0, hint.find(' '));
    std::vector<std::string> names = lammps_style_columns(style);
    if (names.empty()) {
      style = guessed_style_ = lammps_style_of(words_, header_.types);
      names = lammps_style_columns(style);
    }
    if (!names.empty()) {
      // A hybrid style has columns of its own after the position.
      while (style == "hybrid" && names.size() < words_.size()) names.emplace_back();
      return names;
    }
    input_.fail("cannot tell the atom style from " + std::to_string(words_.size()) +
                " columns: write its name, such as 'Atoms # full'");
  }

  [[noreturn]] void fail_width(std::size_t width) const {
    input_.fail(std::to_string(words_.size()) + " columns where the atom style has " +
                std::to_string(width) + ", or " + std::to_string(width + image_flags) +
                " with image flags: write its name, such as 'Atoms # full'");
  }

  Particles finish() {
    Particles particles = columns_.finish();
    add_velocities(particles);
    particles.cell = header_.cell();
    if (!guessed_style_.empty()) {
      particles.facts.notes.push_back({"guessed_style", particles.count(),
                                       "atoms read as of atom style " +
                                           std::string(guessed_style_) +
                                           ", by their number of columns"});
    }
    std::vector<double> masses;
    for (std::string& name : particles.types.names) {
      const auto mass = masses_.find(name);
      masses.push_back(mass == masses_.end() ? unknown_number : mass->second);
      if (const auto label = labels_.find(name); label != labels_.end()) name = label->second;
    }
    take_elements_of_masses(masses, particles);
    return particles;
  }

  void add_velocities(Particles& particles) const {
    for (std::size_t axis = 0; axis < velocity_names.size() && !velocities_.empty(); ++axis) {
      const std::string_view name = velocity_names.at(axis);
      if (!request_.wants(name)) continue;
      NumberColumn column{std::string(name), {}};
      for (const std::string& id : ids_) {
        const auto known = velocities_.find(id);
        column.values.push_back(known == velocities_.end() ? unknown_number
                                                           : known->second.at(axis));
      }
      particles.numbers.push_back(std::move(column));
    }
  }

  static constexpr std::size_t image_flags = 3;
  static constexpr std::uint64_t least_row_bytes = 10;  // "1 1 0 0 0\n"
  static constexpr std::array<std::string_view, 3> velocity_names{"vx", "vy", "vz"};

  const ParticleRequest& request_;
  ParticleInput input_;
  ParticleColumns columns_;
  std::string_view text_;     // of the current line
  std::string_view comment_;  // behind it
  Fields words_;              // of the text
  DataHeader header_;
  bool have_atoms_ = false;
  std::string_view guessed_style_;
  std::map<std::string, double> masses_;                               // by type
  std::map<std::string, std::string> labels_;                          // by type
  std::vector<std::string> ids_;                                       // of atoms
  std::unordered_map<std::string, std::array<double, 3>> velocities_;  // by id
};

}  // namespace

Particles read_lammps_data(PackedFile& file, const ParticleRequest& request) {
  return DataFile(file, request).read();
}

}  // namespace parray::input
