#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "common/rooms.h"

namespace parray::input {

/// The names of a table's columns as layout_of() knows them: in lower case, without a unit in
/// brackets at the end ("x [nm]", "vx (m/s)"), and positions as x, y and z, which programs write as
/// pos_x, PositionX, x_coord, Points:0 (ParaView), Position.X (OVITO) and the like. A column that
/// is called x is the position, whatever else there is.
std::vector<std::string> csv_names(const std::vector<std::string_view>& header);

}  // namespace parray::input
