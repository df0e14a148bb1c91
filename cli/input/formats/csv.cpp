#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "cli/input/formats/format_table.h"
#include "cli/input/formats/row_layout.h"
#include "cli/input/formats/table_names.h"
#include "cli/input/formats/table_rows.h"
#include "cli/input/formats/table_shape.h"
#include "cli/input/particles/length_unit.h"
#include "cli/input/particles/particle_columns.h"
#include "cli/input/particles/particle_input.h"
#include "cli/output/picture/srgb.h"
#include "common/base/printable.h"
#include "common/base/text.h"
#include "common/scene/limits.h"

namespace parray::input {
namespace {

/// Returns the first two lines that are neither blank nor comments.
Fields first_rows(const FileStart& start) {
  Fields rows;
  for (const std::string_view line : start.lines()) {
    if (trimmed(line).empty() || is_table_comment(line)) continue;
    rows.push_back(line);
    if (rows.size() == 2) break;
  }
  return rows;
}

/// Judges a table whose first row has names, none of them positions.
Confidence looks_like_other_names(const FileStart& start) {
  const Fields rows = first_rows(start);
  if (rows.empty()) return Confidence::none;
  constexpr std::string_view separators = " \t,;\"";
  const std::string header = lower_case(rows[0]);
  const Fields names = words_of(header, separators);
  if (places_of_three(names, {"x", "y", "z"})) return Confidence::likely;
  if (rows.size() < 2 || names.size() < 3) return Confidence::none;
  const Fields fields = words_of(rows[1], separators);
  const auto numbers = std::ranges::count_if(fields, is_number);
  return fields.size() == names.size() && numbers >= 3 ? Confidence::possible : Confidence::none;
}

Confidence looks_like_csv(const FileStart& start) {
  if (start.has("%%MatrixMarket")) return Confidence::none;
  const TableShape shape = table_shape(start);
  if (shape.certain) return Confidence::likely;
  return shape.names == TableShape::Names::header ? looks_like_other_names(start)
                                                  : Confidence::possible;
}

/// Gives columns without a unit the units of ECSV. `header`: the names in the file.
void take_ecsv_units(const std::vector<std::pair<std::string, std::string>>& units,
                     const Fields& header, TableNames& table) {
  for (const auto& [name, unit] : units) {
    const auto column = place_in(header, name);
    if (column && table.units[*column].empty()) table.units[*column] = readable_unit(unit);
  }
}

/// Converts radii to the unit of the positions, if both units are known. Returns the end of a note
/// about it, or "".
std::string convert_radii(const TableNames& table, std::string_view length, RowLayout& layout) {
  const std::string unit = layout.radius ? table.units[*layout.radius] : "";
  const LengthUnit* const from = length_unit(unit);
  const LengthUnit* const to = length_unit(length);
  if (from == nullptr || to == nullptr || from == to) return {};
  if (from->metres == 0 || to->metres == 0) return {};
  layout.radius_factor *= from->metres / to->metres;
  return " converted from " + std::string(from->name) + " to " + std::string(to->name);
}

/// Reads rows whose columns have names. `place`: the place of the names.
Particles read_named_table(TableRows& rows, const ParticleInput& input, TableNames table,
                           const FilePlace& place, const ParticleRequest& request) {
  refuse_sky_coordinates(table, place);
  RowLayout layout = layout_of(table.names, place);
  use_diameters(table.names, layout);
  layout.color_scale = ColorScale::either;
  layout.strict_elements = true;
  const Fields* row = rows.next();
  if (row != nullptr && take_units(*row, table)) row = rows.next();
  const std::string length = unit_of_positions(table, place);
  const std::string conversion = convert_radii(table, length, layout);

  std::vector<NumberField> fields = other_fields(table.names, layout);
  for (NumberField& field : fields) field.unit = table.units[field.column];
  ParticleColumns columns(input.place());
  want_numbers(fields, request, layout, columns);
  for (; row != nullptr; row = rows.next()) {
    if (row->size() != table.names.size()) {
      input.fail(std::to_string(row->size()) + " fields, but the header has " +
                 std::to_string(table.names.size()) + ": use the same number");
    }
    add_row(*row, layout, input.place(), columns);
  }
  Particles particles = columns.finish();
  particles.facts.length_unit = length;
  if (!conversion.empty()) {
    particles.facts.notes.push_back({"converted_radii", particles.count(),
                                     in_number(particles.count(), "radius", "radii") + conversion});
  }
  if (rows.has_decimal_commas()) {
    particles.facts.notes.push_back({"decimal_commas", particles.count(),
                                     in_number(particles.count(), "particle", "particles") +
                                         " in a table with decimal commas"});
  }
  return particles;
}

Particles read_with_header(ParticleInput& input, const TableShape& shape,
                           const ParticleRequest& request) {
  TableRows rows(input, shape.separator);
  if (!rows.next_line()) {
    input.fail("the file has no header line: add one that names the columns x, y and z");
  }
  FieldSplitter splitter(separator_of(input.line()));
  Fields header;
  splitter.split(input.line(), input.place(), header);
  if (separator_of(input.line()) == blank_separator) join_units(header);
  TableNames table = table_names(header);
  take_ecsv_units(shape.units, header, table);
  const FilePlace place = input.place();
  return read_named_table(rows, input, std::move(table), place, request);
}

constexpr std::size_t axis_count = 3;
constexpr std::size_t with_radius = 4;  // number of columns
constexpr std::size_t with_colors = 6;
constexpr std::size_t with_colors_and_intensity = 7;
constexpr std::uint64_t least_plain_row_bytes = 6;  // "0 0 0\n"

std::string name_of_column(std::size_t column) { return "c" + std::to_string(column + 1); }

/// Returns the first of the three columns that may be colours.
std::optional<std::size_t> first_color(const TableShape& shape) {
  const bool scan = shape.counted && shape.columns == with_colors_and_intensity;
  if (scan || shape.columns == with_colors) return shape.columns - axis_count;
  return {};
}

/// The columns after x, y and z. Columns that may be radii or colours are read as numbers first,
/// because every number of the file matters for the choice.
class FurtherColumns {
 public:
  FurtherColumns(const TableShape& shape, const ParticleRequest& request, ParticleColumns& columns)
      : shape_(shape), request_(request) {
    const std::size_t first = first_color(shape).value_or(shape.columns);
    for (std::size_t i = axis_count; i < shape.columns; ++i) {
      const bool candidate = shape.columns == with_radius || i >= first;
      const bool read = candidate || request.wants(name_of_column(i));
      places_.push_back(read ? std::optional(columns.add_numbers(name_of_column(i)))
                             : std::nullopt);
    }
  }

  /// Reads the columns of a row from its first column on.
  void add(const Fields& row, const FilePlace& place, ParticleColumns& columns) const {
    for (std::size_t i = axis_count; i < shape_.columns; ++i) {
      const std::string_view text = row[shape_.first + i];
      const std::optional<double> value = number_in(text);
      if (!value) {
        place.fail(name_of_column(i) + " '" + printable(text) +
                   "' is not a finite number: write a number, or add a header line with the names "
                   "of the columns");
      }
      if (const auto& column = places_[i - axis_count]) columns.number(*column, *value);
    }
  }

  /// Turns numbers into radii or colours. Removes numbers that the request does not want. Returns
  /// the names of all columns.
  std::vector<std::string> decide(Particles& particles) const {
    std::vector<std::string> names{"x", "y", "z"};
    for (std::size_t i = axis_count; i < shape_.columns; ++i) names.push_back(name_of_column(i));
    if (shape_.columns == with_radius && take_radii(particles)) names[axis_count] = "radius";
    if (const auto first = first_color(shape_); first && take_colors(*first, particles)) {
      names.resize(*first);
      for (const char* color : {"red", "green", "blue"}) names.emplace_back(color);
    }
    std::erase_if(particles.numbers, [&](const NumberColumn& column) {
      return !request_.wants(column.name) || column.values.empty();
    });
    return names;
  }

 private:
  static std::vector<double>& values(std::size_t column, Particles& particles) {
    return std::ranges::find(particles.numbers, name_of_column(column), &NumberColumn::name)
        ->values;
  }

  static bool take_radii(Particles& particles) {
    std::vector<double>& radii = values(axis_count, particles);
    const auto possible = [](double radius) {
      return radius >= limits::min_radius && radius <= limits::max_length;
    };
    if (!std::ranges::all_of(radii, possible)) return false;
    particles.radii = std::exchange(radii, {});
    return true;
  }

  static bool take_colors(std::size_t first, Particles& particles) {
    const auto is_byte = [](double value) {
      return value >= 0 && value <= 255 && std::floor(value) == value;
    };
    bool bright = false;
    for (std::size_t i = first; i < first + axis_count; ++i) {
      const std::vector<double>& component = values(i, particles);
      if (!std::ranges::all_of(component, is_byte)) return false;
      bright = bright || std::ranges::any_of(component, [](double value) { return value > 1; });
    }
    if (!bright) return false;
    std::vector<double>& red = values(first, particles);
    std::vector<double>& green = values(first + 1, particles);
    std::vector<double>& blue = values(first + 2, particles);
    for (std::size_t i = 0; i < particles.count(); ++i) {
      particles.colors.push_back(linear_of_srgb8({red[i], green[i], blue[i]}));
    }
    red = green = blue = {};
    return true;
  }

  const TableShape& shape_;
  const ParticleRequest& request_;
  std::vector<std::optional<std::size_t>> places_;  // by column after z
};

/// Returns the names as a list, without the middle of a long one.
std::string list_of(std::vector<std::string> names) {
  constexpr std::size_t most = 9;
  if (names.size() <= most) return joined(names, ", ");
  const std::string last = names.back();
  names.resize(most - 2);
  return joined(names, ", ") + " to " + last;
}

/// Reads a table of numbers without names (TableShape::Names::none). The first three columns are x,
/// y and z. The fourth of four columns is the radius, if all its numbers are allowed radii. The
/// last three columns are colours (8-bit sRGB) if there are six columns, or seven in a file with a
/// count (.pts), and if these three are whole numbers from 0 to 255 and not all 0 or 1. Every other
/// column is numeric, with the name c4, c5 and so on, and is read if the request wants it. A note
/// says how the columns were read. `rows` reads from `input` and must not have read any row. Throws
/// the errors of read_particles().
Particles read_plain_table(TableRows& rows, ParticleInput& input, const TableShape& shape,
                           const ParticleRequest& request) {
  ParticleColumns columns(input.place());
  std::optional<std::uint64_t> count;
  if (shape.counted && rows.next_line()) {
    count = count_field(trimmed(input.line()), input.place());
    columns.expect(std::min(*count, input.bytes_left().value_or(0) / least_plain_row_bytes + 1));
  }
  if (shape.numbered) rows.next_line();
  const std::size_t width = shape.first + shape.columns;
  const FurtherColumns further(shape, request, columns);
  while (const Fields* const row = rows.next()) {
    if (count == columns.count()) {
      input.fail("text follows the last particle: check the number of particles in the first line");
    }
    std::size_t size = row->size();
    while (size > width && (*row)[size - 1].empty()) --size;  // "1,2,3,"
    if (size != width) {
      input.fail(std::to_string(size) + " values, but the first row has " + std::to_string(width) +
                 ": use the same number");
    }
    columns.position(position_field(*row, shape.first, input.place()));
    further.add(*row, input.place(), columns);
  }
  if (count && columns.count() < *count) input.next_row(columns.count(), *count, "particles");
  Particles particles = columns.finish();
  const std::string names = list_of(further.decide(particles));
  particles.facts.notes.push_back(
      {"guessed_columns", particles.count(),
       in_number(particles.count(), "particle", "particles") +
           " in a table without names of columns, read as " + names +
           (rows.has_decimal_commas() ? ", with decimal commas" : "") +
           (shape.numbered ? ", without the first row, which numbers the columns" : "")});
  return particles;
}

/// Reads a table of text. layout_of() interprets the names of the columns, in any letter case. They
/// are in the first row, or in a comment before it; read_plain_table() reads a table without names.
/// The first comma, semicolon or tab of the header is the separator; without one, blanks separate
/// fields. Fields may be in double quotes ("" is a quote). Ignores blank lines and comments, which
/// start with #, // or %. Units stand in brackets after names, or in a row below them. Numbers may
/// have decimal commas if the separator is not a comma. If any colour component is above 1, all
/// colours are whole numbers 0 to 255 (8-bit sRGB); otherwise they are linear.
Particles read_csv(PackedFile& file, const ParticleRequest& request) {
  const TableShape shape = table_shape(file.start());
  ParticleInput input(file);
  if (shape.names == TableShape::Names::header) return read_with_header(input, shape, request);
  TableRows rows(input, shape.separator);
  if (shape.names == TableShape::Names::none) return read_plain_table(rows, input, shape, request);
  if (shape.counted) rows.next_line();
  const FilePlace place{file.name(), FilePlace::Unit::line, shape.line};
  return read_named_table(rows, input, shape.comment, place, request);
}

}  // namespace

constinit const ParticleFormat csv_format{.name = "CSV",
                                          .extensions = {".csv", ".tsv", ".pts"},
                                          .confidence = looks_like_csv,
                                          .read = read_csv};

}  // namespace parray::input
