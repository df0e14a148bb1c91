#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "cli/input/particles/particle_columns.h"

namespace parray::input {

/// Numbers of a row under a name: one column, or the length of the vector in three.
struct NumberField {
  std::string name;
  std::size_t column = 0;  ///< the first
  bool length = false;
};

/// Which column of a table of text holds what; columns count from 0.
struct RowLayout {
  std::array<std::size_t, 3> position{};
  std::optional<std::size_t> radius;
  std::optional<std::array<std::size_t, 3>> color;
  std::optional<std::size_t> element;
  std::optional<std::size_t> type;
  double radius_factor = 1;  ///< 0.5 where the file holds diameters
  ColorScale color_scale = ColorScale::linear;
  std::vector<NumberField> numbers;  ///< in the order of ParticleColumns' own
  bool strict_elements = false;      ///< a text that is no element is an error, not "unknown"
};

using Fields = std::vector<std::string_view>;

/// The position in a row that has all columns of `layout`.
Vec3d position_of(const Fields& row, const RowLayout& layout, const FilePlace& place);

/// Takes the column `diameter` where there is none of radii.
void use_diameters(const std::vector<std::string>& names, RowLayout& layout);

/// Has `layout` and `columns` take the numbers of `fields` that the request wants.
void want_numbers(const std::vector<NumberField>& fields, const ParticleRequest& request,
                  RowLayout& layout, ParticleColumns& columns);

/// The fields of a table's columns that `layout` has no other use for, under their own names.
std::vector<NumberField> other_fields(const std::vector<std::string>& names,
                                      const RowLayout& layout);

/// Adds what stands beside the position. Where the layout has no types, the elements' texts are
/// the types.
void add_attributes(const Fields& row, const RowLayout& layout, const FilePlace& place,
                    ParticleColumns& columns);

/// Adds a particle. Numbers that are none are not known.
void add_row(const Fields& row, const RowLayout& layout, const FilePlace& place,
             ParticleColumns& columns);

/// The columns of a header line by their names (lower case): x, y, z; radius; element; type;
/// red, green, blue or r, g, b. `r` without `g` and `b` is a radius. Other names are passed over.
/// Fails at `place` when x, y or z is missing, or a name that counts stands there twice.
RowLayout layout_of(const std::vector<std::string>& names, const FilePlace& place);

}  // namespace parray::input
