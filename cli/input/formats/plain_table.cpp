#include "cli/input/formats/plain_table.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "cli/input/particles/particle_columns.h"
#include "cli/output/picture/srgb.h"
#include "common/base/printable.h"
#include "common/base/text.h"
#include "common/scene/limits.h"

namespace parray::input {
namespace {

using Words = std::vector<std::string_view>;

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
  void add(const Words& row, const FilePlace& place, ParticleColumns& columns) const {
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
  if (names.size() > most) {
    std::string last = std::move(names.back());
    names.resize(most - 2);
    return joined(names, ", ") + " to " + last;
  }
  return joined(names, ", ");
}

ParticleNote note_on_columns(const std::vector<std::string>& names, const TableShape& shape,
                             bool decimal_commas, std::uint64_t count) {
  return {"guessed_columns", count,
          in_number(count, "particle", "particles") +
              " in a table without names of columns, read as " + list_of(names) +
              (decimal_commas ? ", with decimal commas" : "") +
              (shape.numbered ? ", without the first row, which numbers the columns" : "")};
}

void check_width(const Words& row, const TableShape& shape, const ParticleInput& input) {
  const std::size_t width = shape.first + shape.columns;
  std::size_t size = row.size();
  while (size > width && row[size - 1].empty()) --size;  // "1,2,3,"
  if (size == width) return;
  input.fail(std::to_string(size) + " values, but the first row has " + std::to_string(width) +
             ": use the same number");
}

}  // namespace

Particles read_plain_table(TableRows& rows, ParticleInput& input, const TableShape& shape,
                           const ParticleRequest& request) {
  ParticleColumns columns(input.place());
  std::optional<std::uint64_t> count;
  if (shape.counted && rows.next_line()) {
    count = count_field(trimmed(input.line()), input.place());
    columns.expect(std::min(*count, input.bytes_left().value_or(0) / least_plain_row_bytes + 1));
  }
  if (shape.numbered) rows.next_line();
  const FurtherColumns further(shape, request, columns);
  while (const Words* const row = rows.next()) {
    if (count == columns.count()) {
      input.fail("text follows the last particle: check the number of particles in the first line");
    }
    check_width(*row, shape, input);
    const auto axis = [&](std::size_t i, std::string_view name) {
      return number_field((*row)[shape.first + i], name, input.place());
    };
    const double x = axis(0, "x");
    const double y = axis(1, "y");
    columns.position({x, y, axis(2, "z")});
    further.add(*row, input.place(), columns);
  }
  if (count && columns.count() < *count) input.next_row(columns.count(), *count, "particles");
  Particles particles = columns.finish();
  const std::vector<std::string> names = further.decide(particles);
  particles.facts.notes.push_back(
      note_on_columns(names, shape, rows.has_decimal_commas(), particles.count()));
  return particles;
}

}  // namespace parray::input
