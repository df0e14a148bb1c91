#include <algorithm>
#include <set>
#include <string>

#include "cli/input/formats/format_table.h"
#include "cli/input/formats/notes.h"
#include "cli/input/formats/row_layout.h"
#include "cli/input/formats/table_shape.h"
#include "cli/input/particles/cell.h"
#include "cli/input/particles/guess_element.h"
#include "cli/input/particles/particle_input.h"
#include "common/base/ascii.h"
#include "common/base/printable.h"
#include "common/base/text.h"

namespace parray::input {
namespace {

Confidence looks_like_xyz(const FileStart& start) {
  if (!is_natural(trimmed(start.line(0)))) return Confidence::none;
  const std::string comment = lower_case(start.line(1));
  if (comment.find("properties=") < comment.size()) return Confidence::certain;
  if (is_counted_table(start)) return Confidence::none;
  const bool next_frame = is_natural(trimmed(start.line(2)));  // after a frame without particles
  const Fields words = words_of(start.line(2));
  const bool has_position =
      words.size() >= 4 && std::all_of(words.begin() + 1, words.begin() + 4, is_number);
  return next_frame || has_position ? Confidence::likely : Confidence::possible;
}

/// The layout of the rows in a frame.
struct XyzLayout {
  RowLayout row;
  std::vector<NumberField> others;  ///< numbers that a request may want
  std::size_t columns = 4;          ///< number of columns in a row
  bool exact = false;               ///< true: rows must not have further columns
};

constexpr std::string_view lammps_start = "Atoms. Timestep:";
constexpr std::array<std::string_view, 3> axis_endings{"_x", "_y", "_z"};

/// One NAME:TYPE:COUNT of Properties.
struct Property {
  std::string name;  ///< lower case
  char type = 0;
  std::size_t count = 0;
};

/// Removes the text up to the next colon from the front of `text` and returns it.
std::string_view take_part(std::string_view& text) {
  const std::size_t end = std::min(text.find(':'), text.size());
  const std::string_view part = text.substr(0, end);
  text.remove_prefix(std::min(end + 1, text.size()));
  return part;
}

Property take_property(std::string_view& text, const FilePlace& place) {
  const std::string_view name = take_part(text);
  const std::string_view type = take_part(text);
  const std::optional<std::uint64_t> count = natural_in(take_part(text));
  constexpr std::string_view types = "SRIL";
  constexpr std::uint64_t max_count = 1000;
  const bool known_type = type.size() == 1 && types.find(type) < types.size();
  if (name.empty() || !known_type || count.value_or(0) == 0 || *count > max_count) {
    place.fail("Properties has no valid NAME:TYPE:COUNT at '" + printable(name) +
               "': write for example species:S:1:pos:R:3");
  }
  return {lower_case(name), type[0], static_cast<std::size_t>(*count)};
}

/// Adds the numbers of a property that has no special meaning: one number, a vector (its
/// components, and its length under the property's name), or several numbers counted from 0.
void enter_numbers(const Property& property, std::size_t at, XyzLayout& layout) {
  if (property.type == 'S') return;
  if (property.count == 1 || property.count == 3) {
    layout.others.push_back({property.name, at, property.count == 3});
  }
  for (std::size_t i = 0; property.count > 1 && i < property.count; ++i) {
    const std::string ending =
        property.count == 3 ? std::string(axis_endings.at(i)) : "_" + std::to_string(i);
    layout.others.push_back({property.name + ending, at + i, false});
  }
}

/// Adds a property to the layout. Its first column is `at`.
void enter(const Property& property, std::size_t at, XyzLayout& layout, bool& has_position) {
  const std::string_view name = property.name;
  const bool one = property.count == 1;
  const bool three = property.count == 3;
  const bool element = name == "species" || name == "element" || name == "symbols";
  const bool number = name == "z" || name == "numbers";
  if (one && ((element && property.type == 'S') ||
              (number && property.type == 'I' && !layout.row.element))) {
    layout.row.element = at;
  } else if ((name == "type" || name == "species") && one) {
    layout.row.type = at;
  } else if ((name == "pos" || name == "positions") && three) {
    layout.row.position = {at, at + 1, at + 2};
    has_position = true;
  } else if (name == "radius" && one) {
    layout.row.radius = at;
  } else if (name == "color" && three) {
    layout.row.color = {{at, at + 1, at + 2}};
    layout.row.color_scale = property.type == 'I' ? ColorScale::srgb8 : ColorScale::linear;
  } else {
    enter_numbers(property, at, layout);
  }
}

/// Returns the value of KEY=... `key` is in lower case, with "=". Returns "" if the key is missing.
std::string_view value_of(std::string_view comment, std::string_view key) {
  const std::string lower = lower_case(comment);
  std::size_t at = lower.find(key);
  while (at != std::string::npos && at > 0 && !ascii::is_blank(lower[at - 1])) {
    at = lower.find(key, at + 1);  // it was the end of a longer name
  }
  if (at == std::string::npos) return {};
  const std::string_view value = comment.substr(at + key.size());
  constexpr std::string_view opening = "\"'{[";
  constexpr std::string_view closing = "\"'}]";
  const std::size_t quote = value.empty() ? std::string_view::npos : opening.find(value[0]);
  if (quote == std::string_view::npos) return value.substr(0, value.find_first_of(" \t"));
  return value.substr(1, value.find(closing[quote], 1) - 1);
}

/// Parses the numbers of a value. Returns none if one of them is not a number.
std::vector<double> numbers_in(std::string_view value) {
  std::vector<double> numbers;
  for (const std::string_view field : words_of(value, " \t,")) {
    const std::optional<double> number = number_in(field);
    if (!number) return {};
    numbers.push_back(*number);
  }
  return numbers;
}

/// Returns the layout that Properties defines. Without Properties, a row has a name and a position.
/// Throws InputError at `place` for invalid Properties and for Properties without positions.
XyzLayout xyz_layout(std::string_view comment, const FilePlace& place) {
  std::string_view properties = value_of(comment, "properties=");
  XyzLayout layout;
  if (properties.empty()) {
    layout.row.element = 0;
    layout.row.position = {1, 2, 3};
    return layout;
  }
  layout.exact = true;
  layout.columns = 0;
  bool has_position = false;
  while (!properties.empty()) {
    const Property property = take_property(properties, place);
    enter(property, layout.columns, layout, has_position);
    layout.columns += property.count;
  }
  if (!has_position) place.fail("Properties has no pos:R:3: add it");
  return layout;
}

/// Returns whether the comment is that of LAMMPS. Its names are numbers of types, unless the user
/// has set others.
bool is_lammps_comment(std::string_view comment) { return comment.starts_with(lammps_start); }

/// Returns the cell of Lattice, Origin and pbc. Returns nothing if they are not a valid cell.
std::optional<ParticleCell> xyz_cell(std::string_view comment) {
  const std::vector<double> edges = numbers_in(value_of(comment, "lattice="));
  const std::vector<double> origin = numbers_in(value_of(comment, "origin="));
  if (edges.size() != 9) return {};
  const auto edge = [&](std::size_t i) { return Vec3d{edges[i], edges[i + 1], edges[i + 2]}; };
  ParticleCell cell{{}, {edge(0), edge(3), edge(6)}};
  if (origin.size() == 3) cell.origin = {origin[0], origin[1], origin[2]};
  const Fields periodic = words_of(value_of(comment, "pbc="));
  for (std::size_t i = 0; periodic.size() == 3 && i < 3; ++i) {
    cell.periodic.at(i) =
        !periodic[i].starts_with('F') && !periodic[i].starts_with('f') && periodic[i] != "0";
  }
  return valid_cell(cell);
}

/// Returns the time or, without it, the step. Also reads the comment of LAMMPS.
std::optional<double> xyz_time(std::string_view comment) {
  if (is_lammps_comment(comment)) return number_in(trimmed(comment.substr(lammps_start.size())));
  for (const std::string_view key : {"time=", "step=", "timestep=", "frame="}) {
    const std::string_view value = value_of(comment, key);
    if (!value.empty()) return number_in(value);
  }
  return {};
}

constexpr std::size_t least_row_bytes = 8;  // "C 0 0 0\n"

/// Returns whether the names are 1, 2, 3 ... in any order, without a gap.
bool count_from_one(const std::vector<std::string>& names) {
  std::set<std::uint64_t> numbers;
  for (const std::string& name : names) {
    const std::optional<std::uint64_t> number = natural_in(name);
    if (!number || *number == 0 || *number > names.size()) return false;
    numbers.insert(*number);
  }
  return numbers.size() == names.size();
}

/// Decides whether numbers in place of elements are types. LAMMPS writes numbers of types there.
/// Numbers are types if the comment is that of LAMMPS, or if they go from 1 on without a gap,
/// because no system contains all of H, He, Li. Other numbers are atomic numbers.
void distinguish_types_from_elements(std::string_view comment, Particles& particles) {
  const std::vector<std::string>& names = particles.types.names;
  if (particles.elements.empty() || names.empty()) return;
  const bool types =
      is_lammps_comment(comment) ? std::ranges::all_of(names, is_natural) : count_from_one(names);
  if (!types) {
    const auto numbers = std::ranges::count_if(
        particles.types.index, [&](std::uint32_t name) { return is_natural(names[name]); });
    add_note(particles.facts.notes,
             guessed_elements_note(static_cast<std::uint64_t>(numbers), "given by atomic numbers"));
    return;
  }
  particles.elements = {};
  particles.facts.notes.push_back(
      {"numbers_as_types", particles.count(),
       in_number(particles.count(),
                 "particle with a number as its name, read as a type and not as an element",
                 "particles with numbers as names, read as types and not as elements")});
}

/// Reads frames. Each frame is a count, a comment and `count` rows.
class XyzFrames final : public FramesOf<ParticleInput> {
 public:
  XyzFrames(PackedFile& file, const ParticleRequest& request) : FramesOf(file, request) {
    at_count_ = input_.next_line();
  }

  bool next() override {
    if (!at_count_) return false;
    count_ = count_field(trimmed(input_.line()), input_.place());
    if (!input_.next_line()) input_.fail_incomplete("the file ends before its comment line");
    return true;
  }

  std::uint64_t skip() override {
    input_.skip_rows(count_);
    go_to_count();
    return count_;
  }

  Particles read() override {
    const std::string comment(input_.line());
    XyzLayout layout = xyz_layout(comment, input_.place());
    ParticleColumns columns(input_.place());
    columns.expect(std::min(count_, input_.bytes_left().value_or(0) / least_row_bytes + 1));
    want_numbers(layout.others, request_, layout.row, columns);
    Fields row;
    for (std::uint64_t i = 0; i < count_; ++i) {
      input_.next_row(i, count_, "particles");
      split_at_blanks(input_.line(), row);
      if (row.size() < layout.columns || (layout.exact && row.size() > layout.columns)) {
        input_.fail(
            std::to_string(row.size()) + " columns, but " + std::to_string(layout.columns) +
            " are needed: " +
            (layout.exact
                 ? "write the number that Properties requires"
                 : "write a name and three coordinates, or correct the number of particles"));
      }
      add_row(row, layout.row, input_.place(), columns);
    }
    go_to_count();
    Particles particles = columns.finish_frame();
    distinguish_types_from_elements(comment, particles);
    particles.cell = xyz_cell(comment);
    particles.facts.time = xyz_time(comment);
    return particles;
  }

 private:
  /// Goes to the count of the next frame, or to the end of the file. Fails for other text.
  void go_to_count() {
    at_count_ = input_.next_filled_line();
    if (!at_count_ || natural_in(trimmed(input_.line()))) return;
    input_.fail(
        "text follows the last particle: check the number of particles in the frame's first line");
  }

  bool at_count_ = false;  // true: at the count of the next frame
  std::uint64_t count_ = 0;
};

}  // namespace

/// Reads XYZ: a count, a comment, then a name and three numbers per line. Ignores further columns.
/// A name is a symbol, an atomic number or any other text (element unknown). Numbers are types,
/// with a note, if the comment is that of LAMMPS or if they go from 1 on without a gap.
/// Reads extended XYZ, whose comment has Properties=NAME:TYPE:COUNT:... It uses species (element,
/// Z), pos, type, radius and color. Colours are linear from 0 to 1 (type R) or 8-bit sRGB (type I).
/// Other properties are numbers on request: vectors as name_x, name_y, name_z, and their length as
/// name. Lattice, Origin and pbc are the cell. Time or, without it, the step is the time.
constinit const ParticleFormat xyz_format =
    frames_in_angstrom<XyzFrames>("XYZ", {".xyz", ".extxyz"}, looks_like_xyz);

}  // namespace parray::input
