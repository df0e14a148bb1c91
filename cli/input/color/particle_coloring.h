#pragma once

#include <array>
#include <optional>
#include <set>
#include <string>
#include <string_view>

#include "cli/input/select/text_range.h"
#include "cli/output/picture/color_map.h"

namespace parray::input {

/// What the colours of particles mean. By default, they mean nothing.
struct ParticleColoring {
  std::string by;                 ///< one of color_by_words, or the name of a number; empty: none
  std::optional<ColorMap> map{};  ///< colour map for numbers; not given: viridis
  TextRange
      range{};  ///< numbers at the ends of the map; percent: of the particles shown; open: all

  [[nodiscard]] bool empty() const { return by.empty(); }
  friend bool operator==(const ParticleColoring&, const ParticleColoring&) = default;
};

/// Words for categories. Any other text is the name of a number (columns.h).
inline constexpr std::array<std::string_view, 5> color_by_words{"element", "type", "chain",
                                                                "residue", "atom"};

/// Parse the texts of the members. Throw InputError, which names no place, for invalid texts.
std::string color_by_from(std::string_view text);
std::optional<ColorMap> color_map_from(std::string_view text);
TextRange color_range_from(std::string_view text);
/// Returns the text that color_map_from() parses to `map`. Returns "" if no map is chosen.
std::string text_of(const std::optional<ColorMap>& map);

/// A contradiction between the members, and the member that is wrong.
struct ColoringProblem {
  std::string key;
  std::string text;
};
std::optional<ColoringProblem> problem_with(const ParticleColoring& coloring);

/// Returns the numeric columns of the file that the colouring needs.
std::set<std::string, std::less<>> numbers_of(const ParticleColoring& coloring);

}  // namespace parray::input
