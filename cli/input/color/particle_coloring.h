#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "cli/input/color/text_range.h"
#include "cli/output/picture/color_map.h"

namespace parray::input {

/// How numbers get colours.
enum class NumberScale : std::uint8_t {
  linear,     ///< in equal steps of the number
  log,        ///< in equal steps of its logarithm; numbers that are not above 0 count as unknown
  categories  ///< each number is a category; 24 colours in turn
};
/// Words for NumberScale, in the order of the enumeration.
inline constexpr std::array<std::string_view, 3> number_scale_words{"linear", "log", "categories"};

/// What the colours of particles mean. By default, they mean nothing.
struct ParticleColoring {
  std::string by;                 ///< one of color_by_words, or the name of a number; empty: none
  std::optional<ColorMap> map{};  ///< for a linear or logarithmic scale; not given: viridis
  /// Numbers at the ends of the map. A percentage is a percentile of the known numbers of the
  /// particles that get these colours. An open end is the least or largest of these numbers. If
  /// both ends are open, they may be symmetric about 0: see colors_of().
  TextRange range{};
  std::optional<NumberScale> scale{};  ///< not given: linear
  /// Categories of all frames of a film, by their names in legends. They take part in the choice of
  /// colours and are in the legend even if no particle belongs to them. Scene files do not contain
  /// them.
  std::vector<std::string> names{};

  [[nodiscard]] bool empty() const { return by.empty(); }
  friend bool operator==(const ParticleColoring&, const ParticleColoring&) = default;
};

/// Words for categories. Any other text is the name of a number (columns.h).
inline constexpr std::array<std::string_view, 5> color_by_words{"element", "type", "chain",
                                                                "residue", "atom"};

/// Parse the texts of the members. The results always have a value. Throw InputError, which names
/// no place, for invalid texts. color_by_from() accepts every text that is not blank, and returns
/// it in lower case.
std::string color_by_from(std::string_view text);
std::optional<ColorMap> color_map_from(std::string_view text);
TextRange color_range_from(std::string_view text);
std::optional<NumberScale> number_scale_from(std::string_view text);
/// Returns the text that color_map_from() parses to `map`. Returns "" if no map is chosen.
std::string text_of(const std::optional<ColorMap>& map);
/// Returns the text that number_scale_from() parses to `scale`. Returns "" if no scale is chosen.
std::string text_of(const std::optional<NumberScale>& scale);

/// A contradiction between the members.
struct ColoringProblem {
  std::string key;   ///< the wrong member's key in a scene file, such as "colormap"
  std::string text;  ///< problem and remedy, to follow the key in a message
};
/// Returns the first contradiction. Returns nothing if the members agree.
std::optional<ColoringProblem> problem_with(const ParticleColoring& coloring);

}  // namespace parray::input
