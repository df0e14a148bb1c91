#include "cli/input/color/particle_coloring.h"

#include <algorithm>

#include "cli/input/select/columns.h"
#include "common/base/error.h"
#include "common/base/printable.h"
#include "common/base/suggest.h"
#include "common/base/text.h"

namespace parray::input {
namespace {

constexpr const char* range_remedy =
    " is not a range: write two ascending numbers, or two ascending percentages of the particles, "
    "such as 1%:99%";

bool is_category(std::string_view by) {
  return std::ranges::find(color_by_words, by) != color_by_words.end();
}

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
  const std::optional<ColorMap> map = color_map_named(text);
  if (map) return map;
  throw InputError("unknown colour map '" + printable(text) +
                   "': " + remedy_for_name(text, color_map_words));
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
  if (const auto place = place_in(number_scale_words, text)) {
    return static_cast<NumberScale>(*place);
  }
  throw InputError("unknown colour scale '" + printable(text) +
                   "': " + remedy_for_name(text, number_scale_words));
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
  if (is_category(coloring.by)) {
    return ColoringProblem{key, "works only with numbers, and '" + printable(coloring.by) +
                                    "' is not a number: leave it out"};
  }
  if (coloring.scale == NumberScale::categories && (coloring.map || !coloring.range.open())) {
    return ColoringProblem{key, "has no effect on categories: leave it out"};
  }
  return {};
}

std::set<std::string, std::less<>> numbers_of(const ParticleColoring& coloring) {
  if (coloring.empty() || is_category(coloring.by) || !is_requested_column(coloring.by)) return {};
  return {coloring.by};
}

}  // namespace parray::input
