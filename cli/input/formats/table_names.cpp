#include "cli/input/formats/table_names.h"

#include <algorithm>
#include <optional>

#include "cli/input/formats/row_layout.h"
#include "cli/input/particles/length_unit.h"
#include "common/base/ascii.h"
#include "common/base/printable.h"
#include "common/base/text.h"

namespace parray::input {
namespace {

using AxisNames = std::array<std::string, 3>;

constexpr std::array<std::string_view, 3> axis_letters{"x", "y", "z"};
constexpr std::array<std::string_view, 3> axis_numbers{"0", "1", "2"};
constexpr std::array<std::string_view, 3> size_names{"radius", "diameter", "r"};
constexpr std::array<std::string_view, 14> words_for_positions{
    "",       "pos",        "position", "positions", "point",    "points",   "coord",
    "coords", "coordinate", "center",   "centre",    "centroid", "location", "coordinates"};

/// A name of the header, and its unit.
struct ColumnName {
  std::string name;  ///< lower case
  std::string unit;  ///< as in the header; empty: none
};

/// Splits "speed [m/s]" at its brackets. The brackets of "stress[1]" and "velocity (x)" belong to
/// the name. Other brackets without a letter hold no unit: "charge [-]".
ColumnName split_brackets(std::string_view text) {
  for (const std::string_view brackets : {"[]", "()"}) {
    const std::size_t open = text.rfind(brackets[0]);
    if (open == std::string_view::npos || open == 0 || !text.ends_with(brackets[1])) continue;
    const std::string_view unit = trimmed(text.substr(open + 1, text.size() - open - 2));
    const bool is_index = is_natural(unit) && !ascii::is_blank(text[open - 1]);
    if (is_index || place_in(axis_letters, lower_case(unit))) continue;
    const bool empty = unit.find_first_not_of("-0123456789") == std::string_view::npos;
    return {lower_case(trimmed(text.substr(0, open))), empty ? "" : std::string(unit)};
  }
  return {lower_case(text), ""};
}

/// Removes marks: "Points:0" and "points_0" become equal.
std::string bare(std::string_view name) {
  std::string letters;
  for (const char c : name) {
    const bool beyond_ascii = static_cast<unsigned char>(c) >= 0x80;
    if (ascii::is_lower(c) || ascii::is_digit(c) || beyond_ascii) letters += c;
  }
  return letters;
}

/// Returns the known sets of names for three axes, by preference.
const std::vector<AxisNames>& ways_to_write_axes() {
  static const std::vector<AxisNames> all = [] {
    std::vector<AxisNames> ways;
    const auto add = [&ways](const auto& name_of) {
      ways.push_back({name_of(std::size_t{0}), name_of(std::size_t{1}), name_of(std::size_t{2})});
    };
    for (const std::string_view word : words_for_positions) {
      const std::string text(word);
      add([&](std::size_t i) { return text + std::string(axis_letters.at(i)); });
      if (!text.empty()) add([&](std::size_t i) { return text + std::string(axis_numbers.at(i)); });
      add([&](std::size_t i) { return std::string(axis_letters.at(i)) + text; });
    }
    add([](std::size_t i) { return "r" + std::string(axis_letters.at(i)); });  // Rx, Ry, Rz
    add([](std::size_t i) { return std::string(axis_letters.at(i)) + "u"; });  // xu: LAMMPS
    return ways;
  }();
  return all;
}

/// Returns whether the name stands for a coordinate or a size.
bool is_length_name(std::string_view name) {
  const std::string letters = bare(name);
  return place_in(size_names, letters) ||
         std::ranges::any_of(ways_to_write_axes(), [&](const AxisNames& way) {
           return place_in(way, letters).has_value();
         });
}

/// Takes a unit of length off the end of the name of a length: "x_pc", "radius-mm". `text`: the
/// name in its own letter case.
void split_ending(std::string_view text, ColumnName& column) {
  const std::size_t mark = text.find_last_of("_- .");
  if (!column.unit.empty() || mark == std::string_view::npos || mark == 0) return;
  const std::string name = lower_case(trimmed(text.substr(0, mark)));
  if (length_unit(text.substr(mark + 1)) == nullptr || !is_length_name(name)) return;
  column = {name, std::string(text.substr(mark + 1))};
}

/// Finds the columns of a way to write axes. All three have the unit of the first.
std::optional<std::array<std::size_t, 3>> find_axes(const AxisNames& way,
                                                    const std::vector<std::string>& bare_names,
                                                    const std::vector<std::string>& units) {
  std::array<std::size_t, 3> found{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    std::size_t i = 0;
    while (i < bare_names.size() &&
           (bare_names[i] != way.at(axis) || (axis > 0 && units[i] != units[found[0]]))) {
      ++i;
    }
    if (i == bare_names.size()) return {};
    found.at(axis) = i;
  }
  return found;
}

/// Names the columns of positions x, y and z, and another column x "other x". Returns whether the
/// table has positions.
bool name_axes(const std::vector<std::string>& bare_names, TableNames& table) {
  for (const AxisNames& way : ways_to_write_axes()) {
    const auto axes = find_axes(way, bare_names, table.units);
    if (!axes) continue;
    for (std::string& name : table.names) {
      if (place_in(axis_letters, name)) name.insert(0, "other ");
    }
    for (std::size_t i = 0; i < 3; ++i) table.names[axes->at(i)] = axis_letters.at(i);
    return true;
  }
  return false;
}

std::size_t column_named(const TableNames& table, std::string_view name) {
  return place_in(table.names, name).value_or(0);
}

/// Returns the first of `known` that a name equals, as in the table; empty: none.
std::string first_known(const TableNames& table, const auto& known) {
  for (const std::string& name : table.names) {
    if (place_in(known, bare(name))) return name;
  }
  return {};
}

}  // namespace

TableNames table_names(const std::vector<std::string_view>& header) {
  TableNames table;
  std::vector<std::string> bare_names;
  for (const std::string_view text : header) {
    const ColumnName plain = split_brackets(text);
    ColumnName column = plain;
    split_ending(text, column);
    bare_names.push_back(bare(column.name));
    const auto size = place_in(size_names, column.name);
    const bool renamed = size && !place_in(table.names, column.name);
    table.names.push_back(renamed ? column.name : plain.name);
    table.units.push_back(readable_unit(column.unit));
  }
  table.has_positions = places_of_three(table.names, axis_letters) || name_axes(bare_names, table);
  return table;
}

std::vector<std::string_view> words_of_header(std::string_view line) {
  const std::size_t mark = line.find_first_of(",;\t");
  const bool blanks = mark == std::string_view::npos;
  std::vector<std::string_view> words = blanks ? words_of(line) : split_at(line[mark], line);
  if (blanks) join_units(words);
  for (std::string_view& word : words) {
    word = trimmed(word);
    if (word.size() >= 2 && word.starts_with('"') && word.ends_with('"')) {
      word = word.substr(1, word.size() - 2);
    }
  }
  return words;
}

static bool is_bracket(std::string_view word) {
  return word.starts_with('[') || word.starts_with('(');
}

void join_units(std::vector<std::string_view>& words) {
  std::vector<std::string_view> joined;
  bool open = false;
  for (const std::string_view word : words) {
    const bool begins = is_bracket(word);
    const bool follows_name = !joined.empty() && !is_bracket(joined.back());
    if (open || (begins && follows_name)) {
      std::string_view& last = joined.back();
      last = {last.data(), static_cast<std::size_t>(word.data() + word.size() - last.data())};
    } else {
      joined.push_back(word);
    }
    open = (begins || open) && !word.ends_with(']') && !word.ends_with(')');
  }
  words = std::move(joined);
}

bool take_units(const std::vector<std::string_view>& row, TableNames& table) {
  if (row.size() != table.names.size() || !table.has_positions) return false;
  std::vector<std::string> units;
  for (std::string_view text : row) {
    text = trimmed(text);
    const bool enclosed = text.size() > 2 && (text.starts_with('[') || text.starts_with('('));
    units.push_back(readable_unit(enclosed ? text.substr(1, text.size() - 2) : text));
  }
  const std::string& length = units[column_named(table, "x")];
  for (const std::string_view axis : axis_letters) {
    if (length_unit(length) == nullptr || units[column_named(table, axis)] != length) return false;
  }
  table.units = std::move(units);
  return true;
}

std::string unit_of_positions(const TableNames& table, const FilePlace& place) {
  const std::string& first = table.units[column_named(table, axis_letters[0])];
  for (const std::string_view axis : axis_letters) {
    const std::string& unit = table.units[column_named(table, axis)];
    if (unit == first) continue;
    const auto named = [](const std::string& text) { return text.empty() ? "no unit" : text; };
    place.fail("x is in " + printable(named(first)) + ", but " + std::string(axis) + " is in " +
               printable(named(unit)) + ": use one unit for all coordinates");
  }
  return first;
}

std::array<std::string, 2> sky_angles(const TableNames& table) {
  constexpr std::array<std::string_view, 7> ra{"ra",     "radeg",          "raj2000",    "raicrs",
                                               "ra2000", "rightascension", "raepoch2000"};
  constexpr std::array<std::string_view, 9> dec{
      "dec", "decdeg", "dej2000", "deicrs", "dec2000", "dedeg", "declination", "de", "decj2000"};
  constexpr std::array<std::string_view, 2> longitude{"glon", "gallon"};
  constexpr std::array<std::string_view, 2> latitude{"glat", "gallat"};
  for (const auto& angles : {std::array{first_known(table, ra), first_known(table, dec)},
                             {first_known(table, longitude), first_known(table, latitude)}}) {
    if (!angles[0].empty() && !angles[1].empty()) return angles;
  }
  return {};
}

void refuse_sky_coordinates(const TableNames& table, const FilePlace& place) {
  const auto angles = sky_angles(table);
  if (table.has_positions || angles[0].empty()) return;
  constexpr std::array<std::string_view, 3> parallaxes{"parallax", "plx", "parallaxmas"};
  const std::string ra = printable(angles[0]);
  const std::string dec = printable(angles[1]);
  const std::string parallax = first_known(table, parallaxes);
  place.fail("the table has " + ra + " and " + dec + ", but no x, y and z: add x = d cos(" + dec +
             ") cos(" + ra + "), y = d cos(" + dec + ") sin(" + ra + "), z = d sin(" + dec +
             "), where d is the distance" +
             (parallax.empty() ? "" : ", 1000 / " + printable(parallax) + " in parsecs"));
}

}  // namespace parray::input
