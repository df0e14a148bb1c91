#include "common/input/portrait/style.h"

#include <algorithm>

#include "common/base/error.h"
#include "common/base/printable.h"
#include "common/base/suggest.h"

namespace parray {
namespace {

Sky even(double radiance) {
  const Vec3d all{radiance, radiance, radiance};
  return {all, all};
}

}  // namespace

Style style_from(std::string_view name) {
  const auto* const found = std::ranges::find(style_names, name);
  if (found != style_names.end()) return static_cast<Style>(found - style_names.begin());
  throw InputError("unknown style '" + printable(name) +
                   "': " + remedy_for_name(name, style_names));
}

std::string_view name_of(Style style) { return style_names[static_cast<std::size_t>(style)]; }

Sky sky_of(Style style) {
  // Where a flag takes a part of the light, a white surface is to be white nevertheless.
  return style == Style::flat ? even(1) : even(1.15);
}

Finish finish_of(Style style) {
  const LineWidth automatic{LineWidth::Unit::automatic, 0};
  switch (style) {
    case Style::publication:
    case Style::flat:
      return {automatic, 0};
    case Style::night:
      return {{}, usual_depth_cue};
    case Style::studio:
      break;
  }
  return {};
}

}  // namespace parray
