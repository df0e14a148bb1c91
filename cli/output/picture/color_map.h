#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

#include "common/math/vec.h"

namespace parray::picture {

/// Colours for numbers, from low to high, in which equal steps of the number look alike.
enum class ColorMap : std::uint8_t {
  // The first four are by Smith, van der Walt and Firing, made for matplotlib and released under
  // CC0;
  // cividis: Nunez, Anderton and Renslow, "Optimizing colormaps with consideration for color vision
  // deficiency", PLOS ONE 13(7), 2018, under CC BY. In all of them lightness rises evenly.
  viridis,
  magma,
  inferno,
  plasma,
  cividis,
  /// From blue by near white, in the middle, to red: straight lines in Oklab.
  blue_red,
  /// From dark to light: a straight line in Oklab.
  grey,
  /// Violet, blue, green, yellow. In CIE L*a*b* (D65) L* rises evenly from 16 to 90, so that the
  /// order is seen whatever colours are not, and in print without any; a* and b* go along a cubic
  /// Bezier curve whose points were chosen so that equal steps look alike.
  violet_yellow
};

/// As users write them, in the order of the enumeration.
std::span<const std::string_view> color_map_names();
std::optional<ColorMap> color_map_named(std::string_view name);
std::string_view name_of(ColorMap map);

/// The middle of the map stands for a number of its own, such as 0: it is the lightest.
bool is_diverging(ColorMap map);

/// Linear RGB in [0, 1] of a share of the way, 0 to 1.
Vec3d color_at(ColorMap map, double share);

/// Linear RGB of a number that is not known: a grey, which no map but the grey one has, where it is
/// another colour.
Vec3d color_of_unknown(ColorMap map);

}  // namespace parray::picture
