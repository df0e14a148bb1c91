#include "cli/input/color/particle_coloring.h"

#include "common/base/error.h"
#include "common/base/printable.h"
#include "common/base/suggest.h"
#include "common/base/text.h"

namespace parray::input {
namespace {

constexpr const char* range_remedy =
    " is not a range: write two ascending numbers, or two ascending percentages of the particles, "
    "such as 1%:99%";

bool is_possible(const TextRange& range) {
  const auto in_percent = [](const std::optional<RangeEnd>& end) {
    return !end || !end->percent || (end->value >= 0 && end->value <= 100);
  };
  const bool comparable = range.low && range.high && range.low->percent == range.high->percent;
  return in_percent(range.low) && in_percent(range.high) &&
         (!comparable || range.low->value < range.high->value);
}

}  // namespace

std::string color_by_from(std::string_view text) {
  std::string by = lower_case(trimmed(text));
  if (by.empty()) {
    throw InputError("the text is empty: write " + list_names(color_by_words) +
                     ", or the name of a numeric column");
  }
  return by;
}

std::optional<ColorMap> color_map_from(std::string_view text) {
  return static_cast<ColorMap>(known_place("colour map", text, color_map_words));
}

std::string text_of(const std::optional<ColorMap>& map) {
  return map ? std::string(name_of(*map)) : std::string();
}

TextRange color_range_from(std::string_view text) {
  const std::optional<TextRange> range = text_range(text);
  if (range && is_possible(*range)) return *range;
  throw InputError("'" + printable(text) + "'" + range_remedy);
}

std::optional<NumberScale> number_scale_from(std::string_view text) {
  return static_cast<NumberScale>(known_place("colour scale", text, number_scale_words));
}

std::string text_of(const std::optional<NumberScale>& scale) {
  return scale ? std::string(number_scale_words[static_cast<std::size_t>(*scale)]) : std::string();
}

std::optional<ColoringProblem> problem_with(const ParticleColoring& coloring) {
  const char* const key = coloring.map             ? "colormap"
                          : !coloring.range.open() ? "range"
                          : coloring.scale         ? "color_scale"
                                                   : nullptr;
  if (key == nullptr) return {};
  if (coloring.empty()) return ColoringProblem{key, "has no effect without \"color_by\": add it"};
  if (place_in(color_by_words, coloring.by)) {
    return ColoringProblem{key, "works only with numbers, and '" + printable(coloring.by) +
                                    "' is not a number: leave it out"};
  }
  if (coloring.scale == NumberScale::categories && (coloring.map || !coloring.range.open())) {
    return ColoringProblem{key, "has no effect on categories: leave it out"};
  }
  return {};
}

}  // namespace parray::input
