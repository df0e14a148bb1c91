#include "cli/input/view/style.h"

#include "common/base/suggest.h"

namespace parray::input {

Style style_from(std::string_view name) {
  return static_cast<Style>(known_place("style", name, style_names));
}

std::string_view name_of(Style style) { return style_names[static_cast<std::size_t>(style)]; }

Style read_style(const JsonValue& value, const JsonPlace& place) {
  const std::string& name = read_string(value, place);
  const Style style = place.checked(value.line, [&] { return style_from(name); });
  if (style == Style::night) {
    place.fail(
        value.line,
        "night works only with a particle file, because it puts a dark wall behind the particles: "
        "leave style out and set sky and finishing");
  }
  return style;
}

Sky sky_of(Style style) {
  // Light blockers darken white surfaces; a brighter sky keeps them white. But where the picture
  // shows the sky, more than white would outshine details smaller than a pixel.
  const bool seen = style == Style::flat || style == Style::publication;
  const double radiance = seen ? 1 : 1.15;
  const Vec3d all{radiance, radiance, radiance};
  return {all, all};
}

Postprocessing postprocessing_of(Style style) {
  if (style == Style::night) return {.depth_cue = usual_depth_cue};
  if (style == Style::studio) return {};
  return {.outline = {LineWidth::Unit::automatic, 0}};
}

}  // namespace parray::input
