#pragma once

#include <array>
#include <cstdint>
#include <string_view>

#include "cli/input/scene_file/json_value.h"
#include "cli/input/scene_file/postprocessing.h"
#include "common/scene/scene.h"

namespace parray::input {

/// What surrounds the particles of an auto scene, and how its picture is postprocessed.
enum class Style : std::uint8_t {
  studio,       ///< on a pale floor, or before a pale wall, light from the upper left
  publication,  ///< on white, without a floor, light from the upper left, outlines
  flat,         ///< on white, light from everywhere alike, outlines: as textbooks draw
  night         ///< before a dark wall, light from the upper left, what is far fades
};

/// Names of styles, in their order.
inline constexpr std::array<std::string_view, 4> style_names{"studio", "publication", "flat",
                                                             "night"};

/// Throws InputError that names the nearest style.
Style style_from(std::string_view name);
std::string_view name_of(Style style);

/// Reads a scene's key `style`. Throws InputError with the place and the line, also for `night`,
/// which is a wall behind particles and not a sky.
Style read_style(const JsonValue& value, const JsonPlace& place);

/// Returns the even light of the style.
Sky sky_of(Style style);
/// Returns the postprocessing of the style.
Postprocessing postprocessing_of(Style style);

}  // namespace parray::input
