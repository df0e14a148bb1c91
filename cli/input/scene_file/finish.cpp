#include "cli/input/scene_file/finish.h"

#include <array>
#include <charconv>

#include "cli/input/scene_file/json_fields.h"
#include "common/base/error.h"
#include "common/base/printable.h"
#include "common/base/suggest.h"

namespace parray::input {
namespace {

constexpr std::string_view points_unit = "pt";

/// `what` says which numbers there are; a word gets the nearest known one.
double number_within(std::string_view text, NumberRange range, const std::string& what) {
  double value = 0;
  const char* const end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data(), end, value);
  if (error == std::errc() && stop == end && value >= range.least && value <= range.most) {
    return value;
  }
  static constexpr std::array<std::string_view, 2> words{"on", "off"};
  NearestWord nearest(text);
  for (const std::string_view word : words) nearest.offer(word);
  throw InputError("'" + printable(text) + "' is no such value: " +
                   (nearest.best().empty() ? "write on, off or " + what
                                           : "did you mean '" + nearest.best() + "'?"));
}

std::string bounds_of(NumberRange range) {
  return " from " + number_text(range.least) + " to " + number_text(range.most);
}

template <typename Value>
std::optional<Value> value_of(const JsonFields& fields, std::string_view key, NumberRange range,
                              Value (*from_text)(std::string_view), Value (*from_number)(double)) {
  const JsonValue* const value = fields.find(key);
  if (value == nullptr) return {};
  const JsonPlace place = fields.place().at(key);
  if (value->kind == JsonKind::boolean)
    return from_text(fields.boolean_or(key, false) ? "on" : "off");
  if (value->kind == JsonKind::number) return from_number(read_number(*value, place, range));
  try {
    return from_text(read_string(*value, place));
  } catch (const InputError& error) {
    if (value->kind == JsonKind::string) place.fail(value->line, error.what());
    throw;
  }
}

}  // namespace

LineWidth line_width_from(std::string_view text) {
  if (text == "on") return {LineWidth::Unit::automatic, 0};
  if (text == "off") return {};
  const bool points = text.ends_with(points_unit);
  const std::string_view number = points ? text.substr(0, text.size() - points_unit.size()) : text;
  return {
      points ? LineWidth::Unit::points : LineWidth::Unit::pixels,
      number_within(number, drawing_ranges::line_width,
                    "pixels" + bounds_of(drawing_ranges::line_width) + ", or points, as 0.5pt")};
}

double depth_cue_from(std::string_view text) {
  if (text == "on") return usual_depth_cue;
  if (text == "off") return 0;
  return number_within(text, drawing_ranges::depth_cue,
                       "a share" + bounds_of(drawing_ranges::depth_cue));
}

Finish FinishSection::over(const Finish& other) const {
  return {outline.value_or(other.outline), depth_cue.value_or(other.depth_cue)};
}

FinishSection read_finish(const JsonValue& value, const JsonPlace& place) {
  static constexpr std::array<std::string_view, 2> keys{"outline", "depth_cue"};
  const JsonFields fields(value, place, keys);
  FinishSection section;
  section.outline = value_of<LineWidth>(fields, "outline", drawing_ranges::line_width,
                                        line_width_from, [](double x) {
                                          return LineWidth{LineWidth::Unit::pixels, x};
                                        });
  section.depth_cue = value_of<double>(fields, "depth_cue", drawing_ranges::depth_cue,
                                       depth_cue_from, [](double x) { return x; });
  return section;
}

std::string finish_text(const Finish& finish) {
  std::string text;
  const std::string number = number_text(finish.outline.value);
  switch (finish.outline.unit) {
    case LineWidth::Unit::none:
      break;
    case LineWidth::Unit::automatic:
      text += R"("outline":true)";
      break;
    case LineWidth::Unit::pixels:
      text += R"("outline":)" + number;
      break;
    case LineWidth::Unit::points:
      text += R"("outline":")" + number + std::string(points_unit) + '"';
      break;
  }
  if (finish.depth_cue > 0) {
    text += (text.empty() ? "" : ", ") + (R"("depth_cue":)" + number_text(finish.depth_cue));
  }
  return "{" + text + "}";
}

}  // namespace parray::input
