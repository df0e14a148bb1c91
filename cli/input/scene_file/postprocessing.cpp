#include "cli/input/scene_file/postprocessing.h"

#include <array>

#include "common/base/error.h"
#include "common/base/printable.h"
#include "common/base/suggest.h"
#include "common/base/text.h"

namespace parray::input {
namespace {

constexpr std::string_view points_unit = "pt";

/// Parses a number in `range`. Otherwise throws InputError that suggests the nearest word, or
/// numbers as `what` describes.
double number_within(std::string_view text, NumberRange range, const std::string& what) {
  if (const auto value = parsed_between(text, range.least, range.most)) return *value;
  static constexpr std::array<std::string_view, 2> words{"on", "off"};
  NearestWord nearest(text);
  for (const std::string_view word : words) nearest.offer(word);
  throw InputError("'" + printable(text) + "' is not a valid value: " +
                   (nearest.best().empty() ? "write on, off or " + what
                                           : "did you mean '" + nearest.best() + "'?"));
}

std::string bounds_of(NumberRange range) {
  return " from " + number_text(range.least) + " to " + number_text(range.most);
}

}  // namespace

LineWidth line_width_from(std::string_view text) {
  if (text == "on") return {LineWidth::Unit::automatic, 0};
  if (text == "off") return {};
  const bool points = text.ends_with(points_unit);
  const std::string_view number = points ? text.substr(0, text.size() - points_unit.size()) : text;
  return {points ? LineWidth::Unit::points : LineWidth::Unit::pixels,
          number_within(
              number, drawing_ranges::line_width,
              "pixels" + bounds_of(drawing_ranges::line_width) + ", or points, such as 0.5pt")};
}

double depth_cue_from(std::string_view text) {
  if (text == "on") return usual_depth_cue;
  if (text == "off") return 0;
  return number_within(text, drawing_ranges::depth_cue,
                       "a share" + bounds_of(drawing_ranges::depth_cue));
}

Postprocessing PostprocessingSection::over(const Postprocessing& other) const {
  return {outline.value_or(other.outline), depth_cue.value_or(other.depth_cue), other.depths};
}

}  // namespace parray::input
