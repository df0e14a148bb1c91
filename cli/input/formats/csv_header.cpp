#include "cli/input/formats/csv_header.h"

#include <algorithm>
#include <array>

#include "cli/input/particles/particle_text.h"

namespace parray::input {
namespace {

using AxisNames = std::array<std::string, 3>;

constexpr std::array<std::string_view, 3> axis_letters{"x", "y", "z"};
constexpr std::array<std::string_view, 3> axis_numbers{"0", "1", "2"};
constexpr std::array<std::string_view, 13> words_for_positions{
    "pos",        "position", "positions", "point",    "points",   "coord",      "coords",
    "coordinate", "center",   "centre",    "centroid", "location", "coordinates"};

std::string without_unit(std::string name) {
  for (const std::string_view brackets : {"[]", "()"}) {
    const std::size_t open = name.rfind(brackets[0]);
    if (open == std::string::npos || open == 0 || !name.ends_with(brackets[1])) continue;
    name.resize(open);
  }
  return std::string(trimmed(name));
}

/// Letters and digits alone: "Points:0" and "points_0" are the same.
std::string bare(std::string_view name) {
  std::string letters;
  for (const char c : name) {
    if ((c >= 'a' && c <= 'z') || (c >= '0' && c <= '9')) letters += c;
  }
  return letters;
}

/// Ways to write three axes, by preference.
std::vector<AxisNames> ways_to_write_axes() {
  std::vector<AxisNames> ways;
  const auto add = [&ways](const auto& name_of) {
    ways.push_back({name_of(std::size_t{0}), name_of(std::size_t{1}), name_of(std::size_t{2})});
  };
  for (const std::string_view word : words_for_positions) {
    const std::string text(word);
    add([&](std::size_t i) { return text + std::string(axis_letters.at(i)); });
    add([&](std::size_t i) { return text + std::string(axis_numbers.at(i)); });
    add([&](std::size_t i) { return std::string(axis_letters.at(i)) + text; });
  }
  return ways;
}

bool has(const std::vector<std::string>& names, std::string_view name) {
  return std::ranges::find(names, name) != names.end();
}

}  // namespace

std::vector<std::string> csv_names(const std::vector<std::string_view>& header) {
  std::vector<std::string> names = lower_case(header);
  for (std::string& name : names) name = without_unit(name);
  const auto is_there = [&names](std::string_view axis) { return has(names, axis); };
  if (std::ranges::any_of(axis_letters, is_there)) return names;
  std::vector<std::string> bare_names;
  std::ranges::transform(names, std::back_inserter(bare_names), bare);
  for (const AxisNames& way : ways_to_write_axes()) {
    if (!std::ranges::all_of(way, [&](const auto& name) { return has(bare_names, name); }))
      continue;
    for (std::size_t i = 0; i < way.size(); ++i) {
      const auto found = std::ranges::find(bare_names, way.at(i)) - bare_names.begin();
      names[static_cast<std::size_t>(found)] = axis_letters.at(i);
    }
    break;
  }
  return names;
}

}  // namespace parray::input
