#pragma once

#include <array>
#include <cstdint>
#include <string_view>

#include "cli/input/scene_file/json_value.h"
#include "cli/input/scene_file/postprocessing.h"
#include "common/scene/scene.h"

namespace parray::input {

/// What surrounds the particles of an automatic scene, and how its picture is postprocessed.
enum class Style : std::uint8_t {
  studio,       ///< pale floor or pale wall, light from the upper left
  publication,  ///< white background, no floor, light from the upper left, outlines
  flat,         ///< white background, equal light from all sides, outlines, as in textbooks
  night         ///< dark wall, light from the upper left, depth cue
};

/// Names of the styles, in the order of Style.
inline constexpr std::array<std::string_view, 4> style_names{"studio", "publication", "flat",
                                                             "night"};

/// Returns the style of that name. Throws InputError, which suggests the nearest style.
Style style_from(std::string_view name);
std::string_view name_of(Style style);

/// Reads the key `style` of a scene file. Throws InputError with the place and the line. Rejects
/// `night`, because it needs a wall behind particles.
Style read_style(const JsonValue& value, const JsonPlace& place);

/// Returns the uniform sky of the style: white, with radiance 1 or a little more.
Sky sky_of(Style style);
/// Returns the postprocessing of the style.
Postprocessing postprocessing_of(Style style);

}  // namespace parray::input
