#include "cli/input/formats/xyz_comment.h"

#include <algorithm>
#include <string>

#include "cli/input/particles/cell.h"
#include "cli/input/particles/particle_text.h"
#include "common/base/printable.h"

namespace parray::input {
namespace {

constexpr std::string_view lammps_start = "Atoms. Timestep:";
constexpr std::array<std::string_view, 3> axis_endings{"_x", "_y", "_z"};

/// One NAME:TYPE:COUNT of Properties.
struct Property {
  std::string name;  ///< lower case
  char type = 0;
  std::size_t count = 0;
};

/// Takes the text up to the next colon from the front of `text`.
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
  const bool known_type = type.size() == 1 && types.find(type[0]) != std::string_view::npos;
  if (name.empty() || !known_type || count.value_or(0) == 0 || *count > max_count) {
    place.fail("Properties has no NAME:TYPE:COUNT at '" + printable(name) +
               "': write them as species:S:1:pos:R:3");
  }
  return {lower_case(name), type[0], static_cast<std::size_t>(*count)};
}

/// Numbers that nothing else is made of: one, a vector (its components and its length, under its
/// own name), or several, counted from 0.
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

/// Enters a property whose first column is `at`.
void enter(const Property& property, std::size_t at, XyzLayout& layout, bool& has_position) {
  const std::string_view name = property.name;
  const bool one = property.count == 1;
  const bool three = property.count == 3;
  const bool element = name == "species" || name == "element" || name == "symbols";
  if (element && one && property.type == 'S') {
    layout.row.element = at;
  } else if ((name == "z" || name == "numbers") && one && property.type == 'I' &&
             !layout.row.element) {
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

XyzLayout layout_of_properties(std::string_view properties, const FilePlace& place) {
  XyzLayout layout;
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

bool is_blank(char c) { return c == ' ' || c == '\t'; }

/// The value of KEY=...; `key` in lower case, with "=". Empty when it is not there.
std::string_view value_of(std::string_view comment, std::string_view key) {
  const std::string lower = lower_case(comment);
  std::size_t at = lower.find(key);
  while (at != std::string::npos && at > 0 && !is_blank(lower[at - 1])) {
    at = lower.find(key, at + 1);  // the end of a longer name
  }
  if (at == std::string::npos) return {};
  const std::string_view value = comment.substr(at + key.size());
  constexpr std::string_view opening = "\"'{[";
  constexpr std::string_view closing = "\"'}]";
  const std::size_t quote = value.empty() ? std::string_view::npos : opening.find(value[0]);
  if (quote == std::string_view::npos) return value.substr(0, value.find_first_of(" \t"));
  return value.substr(1, value.find(closing[quote], 1) - 1);
}

/// The numbers of a value; none where one of them is no number.
std::vector<double> numbers_in(std::string_view value) {
  std::string text(value);
  std::ranges::replace(text, ',', ' ');
  Fields fields;
  split_at_blanks(text, fields);
  std::vector<double> numbers;
  for (const std::string_view field : fields) {
    const std::optional<double> number = number_in(field);
    if (!number) return {};
    numbers.push_back(*number);
  }
  return numbers;
}

}  // namespace

XyzLayout xyz_layout(std::string_view comment, const FilePlace& place) {
  const std::string_view properties = value_of(comment, "properties=");
  if (!properties.empty()) return layout_of_properties(properties, place);
  XyzLayout plain;
  plain.row.element = 0;
  plain.row.position = {1, 2, 3};
  return plain;
}

std::optional<ParticleCell> xyz_cell(std::string_view comment) {
  const std::vector<double> edges = numbers_in(value_of(comment, "lattice="));
  const std::vector<double> origin = numbers_in(value_of(comment, "origin="));
  if (edges.size() != 9) return {};
  const auto edge = [&](std::size_t i) { return Vec3d{edges[i], edges[i + 1], edges[i + 2]}; };
  ParticleCell cell{{}, {edge(0), edge(3), edge(6)}};
  if (origin.size() == 3) cell.origin = {origin[0], origin[1], origin[2]};
  return valid_cell(cell);
}

std::optional<double> xyz_time(std::string_view comment) {
  if (is_lammps_comment(comment)) return number_in(trimmed(comment.substr(lammps_start.size())));
  for (const std::string_view key : {"time=", "step=", "timestep=", "frame="}) {
    const std::string_view value = value_of(comment, key);
    if (!value.empty()) return number_in(value);
  }
  return {};
}

bool is_lammps_comment(std::string_view comment) { return comment.starts_with(lammps_start); }

}  // namespace parray::input
