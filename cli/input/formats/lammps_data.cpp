#include <algorithm>
#include <array>
#include <cstdint>
#include <map>
#include <span>
#include <unordered_map>
#include <vector>

#include "cli/input/formats/atom_columns.h"
#include "cli/input/formats/bond_fields.h"
#include "cli/input/formats/format_table.h"
#include "cli/input/formats/notes.h"
#include "cli/input/formats/row_layout.h"
#include "cli/input/particles/cell.h"
#include "cli/input/particles/guess_element.h"
#include "cli/input/particles/length_unit.h"
#include "cli/input/particles/particle_columns.h"
#include "cli/input/particles/particle_input.h"
#include "cli/input/particles/stated_bonds.h"
#include "common/base/ascii.h"
#include "common/base/printable.h"
#include "common/base/text.h"

namespace parray::input {
namespace {

/// Recognises data files (LAMMPS manual, "read_data"). After a title, the lines of the header
/// end with words. They may be in any order, with comments between them.
Confidence looks_like_lammps_data(const FileStart& start) {
  bool atoms = false;
  bool box = false;
  for (std::size_t i = 1; i < start.lines().size() && !(atoms && box); ++i) {
    const std::string_view line = start.line(i);
    const std::vector<std::string_view> words = words_of(line.substr(0, line.find('#')));
    if (words.empty()) continue;
    if (is_number(words.front()) && is_number(words.back())) break;  // a row of a section
    atoms = atoms || (words.size() >= 2 && is_natural(words[0]) && words[1] == "atoms");
    box = box || (words.size() >= 4 && (words[2] == "xlo" || words[3] == "avec"));
  }
  return certain_if(atoms && box);
}

struct AtomStyle {
  std::string_view name;
  std::string_view columns;  ///< columns before x, y, z; the first is the atom's number
  std::string_view after{};  ///< columns after x, y, z
};

constexpr std::array<AtomStyle, 24> styles{{
    {"atomic", "id type"},
    {"molecular", "id molecule type"},
    {"bond", "id molecule type"},
    {"angle", "id molecule type"},
    {"full", "id molecule type charge"},
    {"charge", "id type charge"},
    {"sphere", "id type diameter density"},
    {"bpm/sphere", "id molecule type diameter density"},
    {"dipole", "id type charge", "mux muy muz"},
    {"dielectric", "id type charge", "normx normy normz area ed em epsilon curvature"},
    {"hybrid", "id type"},
    {"ellipsoid", "id type ellipsoidflag density"},
    {"line", "id molecule type lineflag density"},
    {"tri", "id molecule type triangleflag density"},
    {"body", "id type bodyflag mass"},
    {"peri", "id type volume density"},
    {"dpd", "id type theta"},
    {"edpd", "id type temperature cv"},
    {"mdpd", "id type rho"},
    {"sph", "id type rho esph cv"},
    {"electron", "id type charge espin eradius"},
    {"spin", "id type", "spx spy spz sp"},
    {"tdpd", "id type"},
    {"template", "id type molecule template_index template_atom"},
}};

bool is_whole(std::string_view text) {
  if (text.starts_with('-') || text.starts_with('+')) text.remove_prefix(1);
  return natural_in(text).has_value();
}

/// Returns the columns of the section Atoms for an atom style, with the names of layout_of():
/// LAMMPS manual, "read_data", table of atom styles. Image flags may follow these columns. Returns
/// nothing if the style is unknown or has no fixed columns.
std::vector<std::string> lammps_style_columns(std::string_view style) {
  const auto* const found = std::ranges::find(styles, style, &AtomStyle::name);
  if (found == styles.end()) return {};
  const std::string text = std::string(found->columns) + " x y z " + std::string(found->after);
  const Fields words = words_of(text);
  return {words.begin(), words.end()};
}

/// Guesses the style of a row without a hint from the number of columns and their content. Returns
/// "" if no style fits. `types` is the number of atom types in the file.
std::string_view lammps_style_of(const Fields& row, std::uint64_t types) {
  std::size_t columns = row.size();
  constexpr std::size_t flags = 3;
  if (columns >= 8 && std::all_of(row.end() - flags, row.end(), is_whole)) columns -= flags;
  const bool third_is_type =
      row.size() > 2 && parsed_between<std::uint64_t>(row[2], 1, types).has_value();
  if (columns == 5) return "atomic";
  if (columns == 6) return third_is_type ? "molecular" : "charge";
  if (columns == 7) return third_is_type ? "full" : "sphere";
  return {};
}

/// Returns whether a line is the keyword of a section (LAMMPS manual, "read_data").
bool is_section(std::string_view text) {
  constexpr auto names = std::to_array<std::string_view>(
      {"Atoms", "Velocities", "Masses", "Ellipsoids", "Lines", "Triangles", "Bodies", "Bonds",
       "Angles", "Dihedrals", "Impropers"});
  if (text.empty() || !ascii::is_upper(text[0])) return false;
  return text.ends_with(" Coeffs") || text.ends_with(" Type Labels") || place_in(names, text);
}

/// The lines "VALUES KEYWORD" before the first section.
class DataHeader {
 public:
  std::uint64_t atoms = 0;
  std::uint64_t types = 0;
  std::uint64_t bonds = 0;
  std::uint64_t bodies = 0;  ///< line segments, triangles and bodies

  void read(const Fields& words, const FilePlace& place) {
    const std::string line = " " + joined(words, " ");
    if (line.ends_with(" atoms")) {
      atoms = count_field(words[0], place);
    } else if (line.ends_with(" atom types")) {
      types = natural_in(words[0]).value_or(0);
    } else if (words.size() == 2 && words[1] == "bonds") {
      bonds = natural_in(words[0]).value_or(0);
    } else if (words.size() == 2 && place_in(body_words, words[1])) {
      bodies += natural_in(words[0]).value_or(0);
    } else if (line.ends_with(" xy xz yz")) {
      take(words, place, tilt_);
    } else if (line.ends_with(" abc origin")) {
      take(words, place, origin_);
    } else {
      read_edge(line, words, place);
    }
  }

  /// Returns the box (LAMMPS manual, "Triclinic (non-orthogonal) simulation boxes").
  [[nodiscard]] std::optional<ParticleCell> cell() const {
    if (general_) {
      return valid_cell({vector(origin_), {vector(rows_[0]), vector(rows_[1]), vector(rows_[2])}});
    }
    const auto side = [&](std::size_t i) { return rows_.at(i)[1] - rows_.at(i)[0]; };
    const auto [xy, xz, yz] = tilt_;
    return valid_cell({{rows_[0][0], rows_[1][0], rows_[2][0]},
                       {Vec3d{side(0), 0, 0}, Vec3d{xy, side(1), 0}, Vec3d{xz, yz, side(2)}}});
  }

 private:
  using Three = std::array<double, 3>;

  static constexpr std::array<std::string_view, 3> body_words{"lines", "triangles", "bodies"};

  static Vec3d vector(const Three& three) { return {three[0], three[1], three[2]}; }

  /// Reads the bounds along an axis, or an edge of a general box.
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
    if (words.size() < to.size()) place.fail_incomplete("the header line has too few numbers");
    for (std::size_t i = 0; i < to.size(); ++i) to[i] = number_field(words[i], "number", place);
  }

  std::array<Three, 3> rows_{};  // bounds by axis, or edges
  Three tilt_{};
  Three origin_{};
  bool general_ = false;
};

/// A LAMMPS data file: a comment, a header, then sections. Each section has a keyword and lines.
class DataFile {
 public:
  DataFile(PackedFile& file, const ParticleRequest& request)
      : request_(request), input_(file), columns_(input_.place()) {}

  Particles read() {
    if (!input_.next_line()) input_.fail_incomplete("the file is empty");
    std::string section;  // empty: in the header
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
    if (!have_atoms_) {
      input_.fail("the file has no section Atoms: check that this is a LAMMPS data file");
    }
    if (bonds_.size() < header_.bonds) {
      input_.fail_incomplete("the file has only " + std::to_string(bonds_.size()) + " of " +
                             std::to_string(header_.bonds) + " bonds");
    }
    return finish();
  }

 private:
  /// Goes to the next line that contains more than a comment.
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
    if (section == "Atoms") {
      input_.fail(
          "text follows the last atom: correct the number of atoms in the header, or remove the "
          "text");
    }
    if (section == "Masses" && words_.size() >= 2) {
      masses_[std::string(words_[0])] = number_or_nan(words_[1]);
    } else if (section == "Velocities" && wants_velocities() && words_.size() >= 4) {
      velocities_[std::string(words_[0])] = {number_or_nan(words_[1]), number_or_nan(words_[2]),
                                             number_or_nan(words_[3])};
    } else if (section == "Atom Type Labels" && words_.size() >= 2) {
      labels_[std::string(words_[0])] = words_[1];
    } else if (section == "Bonds" && header_.bonds > 0) {
      if (words_.size() < 4) {
        input_.fail_incomplete("the line needs number, type and two atoms of a bond");
      }
      bonds_.push_back(numbers_.bond(words_[2], words_[3], input_.place()));
    } else if (section == "Ellipsoids" && words_.size() >= 4) {
      ellipsoids_ += is_ellipsoid(words_[1], words_[2], words_[3]) ? 1 : 0;
    }
  }

  [[nodiscard]] bool wants_velocities() const {
    return std::ranges::any_of(velocity_names, [&](auto name) { return request_.wants(name); });
  }

  void read_atoms(const std::string& hint) {
    if (have_atoms_) input_.fail("the file has two sections Atoms: remove one");
    have_atoms_ = true;
    columns_.expect(std::min(header_.atoms, input_.bytes_left().value_or(0) / least_row_bytes + 1));
    RowLayout layout;
    std::size_t width = 0;
    for (std::uint64_t i = 0; i < header_.atoms; ++i) {
      if (!next_line() || is_section(text_)) {
        input_.fail_incomplete("the atoms end after " + std::to_string(i) + " of " +
                               std::to_string(header_.atoms));
      }
      if (i == 0) {
        const std::vector<std::string> names = names_of_columns(hint);
        width = names.size();
        layout = layout_of(names, input_.place());
        use_diameters(names, layout);
        want_numbers(other_fields(names, layout), request_, layout, columns_);
      }
      if (words_.size() != width && words_.size() != width + image_flags) {
        input_.fail(std::to_string(words_.size()) + " columns, but the atom style has " +
                    std::to_string(width) + ", or " + std::to_string(width + image_flags) +
                    " with image flags: correct the row, or the style in 'Atoms # full'");
      }
      add_row(words_, layout, input_.place(), columns_);
      if (header_.bonds > 0) numbers_.add(parsed<std::int64_t>(words_[0]));
      if (wants_velocities()) ids_.emplace_back(words_[0]);
    }
  }

  /// Returns the columns by the hint after "Atoms". Without a hint, guesses them from the current
  /// line, the first row.
  std::vector<std::string> names_of_columns(const std::string& hint) {
    std::string_view style = std::string_view(hint).substr(0, hint.find(' '));
    std::vector<std::string> names = lammps_style_columns(style);
    if (names.empty()) {
      if (!style.empty()) unknown_style_ = ", because '" + printable(style) + "' is unknown";
      style = guessed_style_ = lammps_style_of(words_, header_.types);
      names = lammps_style_columns(style);
    }
    if (!names.empty()) {
      // A hybrid style has further columns after the position.
      while (style == "hybrid" && names.size() < words_.size()) names.emplace_back();
      return names;
    }
    input_.fail("the atom style is unclear from " + std::to_string(words_.size()) + " columns" +
                unknown_style_ + ": write its name, such as 'Atoms # full'");
  }

  Particles finish() {
    Particles particles = columns_.finish();
    add_velocities(particles);
    particles.cell = header_.cell();
    if (!guessed_style_.empty()) {
      particles.facts.notes.push_back({"guessed_style", particles.count(),
                                       in_number(particles.count(), "atom", "atoms") +
                                           " read with atom style " + std::string(guessed_style_) +
                                           ", guessed from the number of columns" +
                                           unknown_style_});
    }
    std::vector<double> masses;
    for (const std::string& name : particles.types.names) {
      const auto mass = masses_.find(name);
      masses.push_back(mass == masses_.end() ? not_known : mass->second);
    }
    take_elements_of_masses(masses, particles);
    use_labels(particles.types);
    put_in_order(bonds_);
    particles.all_bonds = !bonds_.empty();
    particles.bonds = std::move(bonds_);
    add_note(particles.facts.notes, ellipsoids_note(ellipsoids_));
    add_note(particles.facts.notes,
             {"bodies", header_.bodies,
              in_number(header_.bodies, "line segment, triangle or body shown as a sphere",
                        "line segments, triangles or bodies shown as spheres")});
    return particles;
  }

  /// Replaces the names of types by their labels. Types with the same label become one.
  void use_labels(NameColumn& types) const {
    if (labels_.empty()) return;
    NameIndex labelled;
    std::vector<std::uint32_t> numbers;
    for (const std::string& name : types.names) {
      const auto label = labels_.find(name);
      numbers.push_back(labelled.number_of(label == labels_.end() ? name : label->second));
    }
    for (std::uint32_t& type : types.index) type = numbers[type];
    types.names = labelled.column().names;
  }

  void add_velocities(Particles& particles) const {
    for (std::size_t axis = 0; axis < velocity_names.size() && !velocities_.empty(); ++axis) {
      const std::string_view name = velocity_names.at(axis);
      if (!request_.wants(name)) continue;
      NumberColumn column{std::string(name), {}};
      for (const std::string& id : ids_) {
        const auto known = velocities_.find(id);
        column.values.push_back(known == velocities_.end() ? not_known : known->second.at(axis));
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
  std::string_view text_;     // text of the current line without comment
  std::string_view comment_;  // comment of the current line
  Fields words_;              // words of text_
  DataHeader header_;
  bool have_atoms_ = false;
  std::uint64_t ellipsoids_ = 0;
  std::string_view guessed_style_;
  std::string unknown_style_;                  // ", because ..."
  std::map<std::string, double> masses_;       // by type
  std::map<std::string, std::string> labels_;  // by type
  std::vector<std::string> ids_;               // ids of the atoms
  AtomNumbers numbers_;
  std::vector<StatedBond> bonds_;
  std::unordered_map<std::string, std::array<double, 3>> velocities_;  // by id
};

/// Reads the section Atoms of a style with fixed columns. The hint after "Atoms" names the style;
/// without a hint, the number of columns decides. Elements come from the masses of the types. Notes
/// count ellipsoids and other bodies. The title may name the style of units: "... units = metal".
Particles read_lammps_data(PackedFile& file, const ParticleRequest& request) {
  constexpr std::string_view key = "units = ";
  Particles particles = DataFile(file, request).read();
  const std::string_view title = file.start().line(0);
  const std::size_t at = title.find(key);
  const std::string_view style = at < title.size() ? title.substr(at + key.size()) : "";
  particles.facts.length_unit = length_unit_of_lammps(trimmed(style));
  return particles;
}

}  // namespace

constinit const ParticleFormat lammps_data_format{.name = "LAMMPS data file",
                                                  .extensions = {".data", ".lmp", ".lammps"},
                                                  .confidence = looks_like_lammps_data,
                                                  .read = read_lammps_data};

}  // namespace parray::input
