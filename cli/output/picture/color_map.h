#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string_view>

#include "common/math/vec.h"

namespace parray::picture {

/// Colour maps for numbers, from low to high. Equal steps of the number look equal.
enum class ColorMap : std::uint8_t {
  // The first four are by Smith, van der Walt and Firing, made for matplotlib and released under
  // CC0; cividis: Nunez, Anderton and Renslow, "Optimizing colormaps with consideration for color
  // vision deficiency", PLOS ONE 13(7), 2018, under CC BY. In each of these five maps, lightness
  // rises evenly.
  viridis,
  magma,
  inferno,
  plasma,
  cividis,
  /// From blue by near white, in the middle, to red: straight lines in Oklab.
  blue_red,
  /// From dark to light: a straight line in Oklab.
  grey,
  /// Violet, blue, green, yellow. In CIE L*a*b* (D65), L* rises evenly from 16 to 90. So the order
  /// is visible with every kind of colour vision, and in print without colours. a* and b* follow a
  /// cubic Bezier curve, so that equal steps look equal.
  violet_yellow
};

/// Names for users, in the order of the enumeration.
inline constexpr std::array<std::string_view, 8> color_map_words{
    "viridis", "magma", "inferno", "plasma", "cividis", "blue-red", "grey", "violet-yellow"};
/// Returns the map with this name; nothing if there is none.
std::optional<ColorMap> color_map_named(std::string_view name);
std::string_view name_of(ColorMap map);

/// Returns whether the middle of the map stands for a special number, such as 0. The middle of such
/// a map is its lightest colour. True only for blue_red.
bool is_diverging(ColorMap map);

/// Returns the colour for a number at `share` of the way from low to high. `share` must be in [0,
/// 1]. The result is linear RGB in [0, 1].
Vec3d color_at(ColorMap map, double share);

/// Returns the colour that stands for an unknown number: grey, but a purple for the map `grey`.
/// Linear RGB.
Vec3d color_of_unknown(ColorMap map);

}  // namespace parray::picture
