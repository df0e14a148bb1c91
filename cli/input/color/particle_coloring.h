#pragma once

#include <optional>
#include <set>
#include <string>
#include <string_view>

#include "cli/input/scene_file/json_fields.h"
#include "cli/input/select/text_range.h"
#include "cli/output/picture/color_map.h"

namespace parray::input {

/// What the colours of a file's particles are to mean; by default nothing of this.
struct ParticleColoring {
  std::string by;                 ///< one of color_by_words, or the name of a number; empty: none
  std::optional<ColorMap> map{};  ///< for numbers; not given: viridis
  TextRange range{};  ///< that the map's ends stand for; percent: of the particles shown; open: all

  [[nodiscard]] bool empty() const { return by.empty(); }
  friend bool operator==(const ParticleColoring&, const ParticleColoring&) = default;
};

/// Categories; any other text is the name of a number, as in number_source.h.
inline constexpr std::array<std::string_view, 5> color_by_words{"element", "type", "chain",
                                                                "residue", "atom"};

/// The texts of the members. Throw InputError, without a place, for what is none.
std::string color_by_from(std::string_view text);
ColorMap color_map_from(std::string_view text);
TextRange color_range_from(std::string_view text);

/// Why these do not go together, as "colormap: PROBLEM: REMEDY"; empty when they do.
struct ColoringProblem {
  std::string key;
  std::string text;
};
std::optional<ColoringProblem> problem_with(const ParticleColoring& coloring);

/// From the keys color_by, colormap and range of an item of a scene's `particles`. Throws
/// InputError with the place.
ParticleColoring read_particle_coloring(const JsonFields& fields);

/// The numeric columns that a reader must be asked for.
std::set<std::string, std::less<>> numbers_of(const ParticleColoring& coloring);

}  // namespace parray::input
