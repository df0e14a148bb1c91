#include "cli/input/formats/row_layout.h"

#include <algorithm>
#include <set>

#include "cli/input/particles/elements.h"
#include "common/base/printable.h"
#include "common/base/text.h"

namespace parray::input {
namespace {

constexpr std::array<std::string_view, 3> axis_names{"x", "y", "z"};

Vec3d vector_of(const Fields& row, const std::array<std::size_t, 3>& columns,
                const std::array<std::string_view, 3>& names, const FilePlace& place) {
  const double x = number_field(row[columns[0]], names[0], place);
  const double y = number_field(row[columns[1]], names[1], place);
  return {x, y, number_field(row[columns[2]], names[2], place)};
}

/// Parses a symbol or an atomic number. Returns 0 for other texts.
std::uint8_t element_in(std::string_view text) {
  const std::optional<std::uint64_t> number = natural_in(text);
  if (!number) return atomic_number_of(text);
  return *number <= last_element ? static_cast<std::uint8_t>(*number) : 0;
}

std::uint8_t strict_element_in(std::string_view text, const FilePlace& place) {
  const std::uint8_t element = element_in(text);
  const bool unknown = text.empty() || text == "X" || text == "x" || text == "0";
  if (element == 0 && !unknown) {
    place.fail(
        "'" + printable(text) +
        "' is not an element: write a symbol, an atomic number or X, or name the column 'type'");
  }
  return element;
}

double value_of(const Fields& row, const NumberField& field) {
  const double x = number_or_nan(row[field.column]);
  if (!field.length) return x;
  return length(
      Vec3d{x, number_or_nan(row[field.column + 1]), number_or_nan(row[field.column + 2])});
}

}  // namespace

RowLayout layout_of(const std::vector<std::string>& names, const FilePlace& place) {
  const auto find = [&](std::string_view name) {
    if (std::ranges::count(names, name) > 1) {
      place.fail("two columns are named '" + std::string(name) + "': rename one");
    }
    return place_in(names, name);
  };
  const auto find_three = [&](const std::array<std::string_view, 3>& three) {
    for (const std::string_view name : three) find(name);
    return places_of_three(names, three);
  };
  RowLayout layout;
  const auto position = find_three(axis_names);
  if (!position) {
    const auto is_missing = [&](std::string_view axis) { return !place_in(names, axis); };
    place.fail("the table has no column '" +
               std::string(*std::ranges::find_if(axis_names, is_missing)) +
               "': name the columns x, y and z");
  }
  layout.position = *position;
  layout.color = find_three({"red", "green", "blue"});
  const auto short_color = find_three({"r", "g", "b"});
  if (!layout.color) layout.color = short_color;
  layout.radius = find("radius");
  if (!layout.radius && !short_color) layout.radius = find("r");
  layout.element = find("element");
  layout.type = find("type");
  return layout;
}

Vec3d position_of(const Fields& row, const RowLayout& layout, const FilePlace& place) {
  return vector_of(row, layout.position, axis_names, place);
}

void add_attributes(const Fields& row, const RowLayout& layout, const FilePlace& place,
                    ParticleColumns& columns) {
  if (layout.radius) {
    columns.radius(layout.radius_factor * number_field(row[*layout.radius], "radius", place));
  }
  if (layout.color) {
    columns.color(vector_of(row, *layout.color, {"red", "green", "blue"}, place),
                  layout.color_scale);
  }
  if (layout.element) {
    const std::string_view text = row[*layout.element];
    const std::uint8_t element =
        layout.strict_elements ? strict_element_in(text, place) : element_in(text);
    element == 0 ? columns.unknown_element() : columns.element(element);
  }
  if (const auto type = layout.type ? layout.type : layout.element) columns.type(row[*type]);
  for (std::size_t i = 0; i < layout.numbers.size(); ++i) {
    columns.number(i, value_of(row, layout.numbers[i]));
  }
}

void use_diameters(const std::vector<std::string>& names, RowLayout& layout) {
  const auto diameter = place_in(names, "diameter");
  if (layout.radius || !diameter) return;
  layout.radius = diameter;
  layout.radius_factor = 0.5;
}

void want_numbers(const std::vector<NumberField>& fields, const ParticleRequest& request,
                  RowLayout& layout, ParticleColumns& columns) {
  for (const NumberField& field : fields) {
    if (!request.wants(field.name)) continue;
    layout.numbers.push_back(field);
    columns.add_numbers(field.name, field.unit);
  }
}

std::vector<NumberField> other_fields(const std::vector<std::string>& names,
                                      const RowLayout& layout) {
  std::set<std::size_t> used(layout.position.begin(), layout.position.end());
  if (layout.color) used.insert(layout.color->begin(), layout.color->end());
  for (const auto& column : {layout.radius, layout.element, layout.type}) {
    if (column) used.insert(*column);
  }
  std::set<std::string_view> known;
  std::vector<NumberField> fields;
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (used.contains(i) || names[i].empty() || !known.insert(names[i]).second) continue;
    fields.push_back({names[i], i, false});
  }
  return fields;
}

void add_row(const Fields& row, const RowLayout& layout, const FilePlace& place,
             ParticleColumns& columns) {
  columns.position(position_of(row, layout, place));
  add_attributes(row, layout, place, columns);
}

}  // namespace parray::input
