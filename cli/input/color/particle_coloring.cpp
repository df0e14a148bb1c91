#include "cli/input/color/particle_coloring.h"

#include <algorithm>
#include <limits>

#include "cli/input/particles/particle_text.h"
#include "cli/input/select/number_source.h"
#include "common/base/error.h"
#include "common/base/printable.h"
#include "common/base/suggest.h"

namespace parray::input {
namespace {

constexpr const char* range_remedy =
    " is no range: write two numbers, or the parts of the particles below them, as 1%:99%";

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

TextRange range_in(const JsonValue& value, const JsonPlace& place) {
  if (value.kind != JsonKind::array) {
    try {
      return color_range_from(read_string(value, place));
    } catch (const InputError&) {
      place.fail(value.line, "no range: write [low, high], or a text such as \"1%:99%\"");
    }
  }
  constexpr NumberRange finite{std::numeric_limits<double>::lowest(),
                               std::numeric_limits<double>::max()};
  if (value.items.size() != 2) place.fail(value.line, "not two numbers: write [low, high]");
  const TextRange range{RangeEnd{read_number(value.items[0], place.at(0), finite)},
                        RangeEnd{read_number(value.items[1], place.at(1), finite)}};
  if (!is_possible(range)) place.fail(value.line, "low is not below high: write [low, high]");
  return range;
}

}  // namespace

std::string color_by_from(std::string_view text) {
  std::string by = lower_case(trimmed(text));
  if (by.empty()) {
    throw InputError("nothing to colour by: write " + list_names(color_by_words) +
                     ", or the name of a number");
  }
  return by;
}

ColorMap color_map_from(std::string_view text) {
  const std::optional<ColorMap> map = color_map_named(text);
  if (map) return *map;
  throw InputError("unknown colour map '" + printable(text) +
                   "': " + remedy_for_name(text, color_map_names()));
}

TextRange color_range_from(std::string_view text) {
  const std::optional<TextRange> range = text_range(text);
  if (range && is_possible(*range)) return *range;
  throw InputError("'" + printable(text) + "'" + range_remedy);
}

std::optional<ColoringProblem> problem_with(const ParticleColoring& coloring) {
  const char* const key = coloring.map ? "colormap" : (coloring.range.open() ? nullptr : "range");
  if (key == nullptr) return {};
  if (coloring.empty()) return ColoringProblem{key, "says nothing without color_by: add that"};
  if (!is_category(coloring.by)) return {};
  return ColoringProblem{
      key, "is for numbers, and '" + printable(coloring.by) + "' is none: leave it out"};
}

ParticleColoring read_particle_coloring(const JsonFields& fields) {
  ParticleColoring out;
  const auto checked = [&](const char* key, const auto& from, auto& member) {
    const JsonValue* const value = fields.find(key);
    if (value == nullptr) return;
    const std::string& text = fields.string(key);
    try {
      member = from(text);
    } catch (const InputError& error) {
      fields.place().at(key).fail(value->line, error.what());
    }
  };
  checked("color_by", color_by_from, out.by);
  checked("colormap", color_map_from, out.map);
  if (const JsonValue* range = fields.find("range")) {
    out.range = range_in(*range, fields.place().at("range"));
  }
  if (const auto problem = problem_with(out)) {
    fields.place().at(problem->key).fail(fields.find(problem->key)->line, problem->text);
  }
  return out;
}

std::set<std::string, std::less<>> numbers_of(const ParticleColoring& coloring) {
  if (coloring.empty() || is_category(coloring.by) || !is_number_column(coloring.by)) return {};
  return {coloring.by};
}

}  // namespace parray::input
