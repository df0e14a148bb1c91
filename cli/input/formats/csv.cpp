#include <algorithm>
#include <utility>

#include "cli/input/formats/format_table.h"
#include "cli/input/formats/plain_table.h"
#include "cli/input/formats/row_layout.h"
#include "cli/input/formats/table_names.h"
#include "cli/input/formats/table_rows.h"
#include "cli/input/formats/table_shape.h"
#include "cli/input/particles/length_unit.h"
#include "cli/input/particles/particle_input.h"
#include "common/base/text.h"

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
  const auto has_name = [&](std::string_view name) { return std::ranges::count(names, name) > 0; };
  if (has_name("x") && has_name("y") && has_name("z")) return Confidence::likely;
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

/// Converts radii to the unit of the positions, if both units are known. Returns a note about it,
/// or an empty one. The note lacks the count and its noun.
ParticleNote convert_radii(const TableNames& table, std::string_view length, RowLayout& layout) {
  const std::string unit = layout.radius ? table.units[*layout.radius] : "";
  const LengthUnit* const from = length_unit(unit);
  const LengthUnit* const to = length_unit(length);
  if (from == nullptr || to == nullptr || from == to) return {};
  if (from->metres == 0 || to->metres == 0) return {};
  layout.radius_factor *= from->metres / to->metres;
  return {"converted_radii", 0,
          " converted from " + std::string(from->name) + " to " + std::string(to->name)};
}

std::vector<NumberField> number_fields(const TableNames& table, const RowLayout& layout) {
  std::vector<NumberField> fields = other_fields(table.names, layout);
  for (NumberField& field : fields) field.unit = table.units[field.column];
  return fields;
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
  ParticleNote radii = convert_radii(table, length, layout);

  ParticleColumns columns(input.place());
  want_numbers(number_fields(table, layout), request, layout, columns);
  for (; row != nullptr; row = rows.next()) {
    if (row->size() != table.names.size()) {
      input.fail(std::to_string(row->size()) + " fields, but the header has " +
                 std::to_string(table.names.size()) + ": use the same number");
    }
    add_row(*row, layout, input.place(), columns);
  }
  Particles particles = columns.finish();
  particles.facts.length_unit = length;
  radii.count = particles.count();
  radii.text.insert(0, in_number(radii.count, "radius", "radii"));
  if (!radii.key.empty()) particles.facts.notes.push_back(std::move(radii));
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
