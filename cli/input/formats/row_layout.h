#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "cli/input/particles/particle_columns.h"
#include "common/base/text.h"

namespace parray::input {

/// A named number of a row: one column, or the length of a vector in three columns.
struct NumberField {
  std::string name;
  std::size_t column = 0;  ///< the first column
  bool length = false;     ///< true: length of the vector in three columns
  std::string unit{};      ///< empty: unknown
};

/// The meaning of the columns in a text table. Columns count from 0.
struct RowLayout {
  std::array<std::size_t, 3> position{};
  std::optional<std::size_t> radius;
  std::optional<std::array<std::size_t, 3>> color;
  std::optional<std::size_t> element;
  std::optional<std::size_t> type;
  /// Factor that turns a value of the column `radius` into a radius: 0.5 for diameters, and another
  /// one if the radii have another unit than the positions.
  double radius_factor = 1;
  ColorScale color_scale = ColorScale::linear;
  std::vector<NumberField> numbers;  ///< in the order of the numeric columns of ParticleColumns
  /// True: texts that are not elements are errors, not "unknown". X, 0 and empty texts are unknown.
  bool strict_elements = false;
};

using Fields = std::vector<std::string_view>;

/// Returns the indices of three words; nothing unless all of them are among `words`.
std::optional<std::array<std::size_t, 3>> places_of_three(
    const auto& words, const std::array<std::string_view, 3>& three) {
  const auto first = place_in(words, three[0]);
  const auto second = place_in(words, three[1]);
  const auto third = place_in(words, three[2]);
  if (!first || !second || !third) return {};
  return {{*first, *second, *third}};
}

/// Returns the position in a row. The row must have all columns of `layout`, also in the functions
/// below. Throws InputError at `place` for texts that are not numbers.
Vec3d position_of(const Fields& row, const RowLayout& layout, const FilePlace& place);

/// Uses the column `diameter` if there is no column of radii.
void use_diameters(const std::vector<std::string>& names, RowLayout& layout);

/// For each field that the request wants, adds a number to `layout` and a column to `columns`.
void want_numbers(const std::vector<NumberField>& fields, const ParticleRequest& request,
                  RowLayout& layout, ParticleColumns& columns);

/// Returns the columns that `layout` does not use, under their own names. Leaves out columns with
/// an empty name or the name of an earlier column.
std::vector<NumberField> other_fields(const std::vector<std::string>& names,
                                      const RowLayout& layout);

/// Adds all values of a particle except its position. If the layout has no types, the texts of the
/// elements are the types. Throws InputError at `place` for radii, colours and (if strict) elements
/// that are not valid. In numeric columns, texts that are not numbers mean "not known".
void add_attributes(const Fields& row, const RowLayout& layout, const FilePlace& place,
                    ParticleColumns& columns);

/// Adds a particle: its position, then the values of add_attributes().
void add_row(const Fields& row, const RowLayout& layout, const FilePlace& place,
             ParticleColumns& columns);

/// Returns the layout for the names of a header line (lower case): x, y, z; radius; element; type;
/// red, green, blue or r, g, b. `r` without `g` and `b` is a radius. Ignores other names. Throws
/// InputError at `place` if x, y or z is missing, or if a used name occurs twice.
RowLayout layout_of(const std::vector<std::string>& names, const FilePlace& place);

}  // namespace parray::input
