#pragma once

#include <array>
#include <string>
#include <string_view>
#include <vector>

#include "cli/input/particles/file_place.h"

/// Names and units of the columns of a text table.
namespace parray::input {

struct TableNames {
  std::vector<std::string> names;  ///< lower case, without units; positions are x, y and z
  std::vector<std::string> units;  ///< one per name, from readable_unit(); empty: unknown
  bool has_positions = false;      ///< x, y and z are among the names
};

/// Returns the names of the columns in the form that layout_of() knows. A unit is in brackets at
/// the end ("x [nm]", "vx (m/s)"). Positions and radii may have the name of a unit of length after
/// a mark ("x_pc", "radius_mm"). Renames position columns to x, y and z. Programs call them pos_x,
/// PositionX, x_coord, Points:0 (ParaView), Position.X (OVITO), Rx and so on. If columns are called
/// x, y and z, no other column becomes a position. If other columns are the positions although some
/// column is called x, y or z, that column becomes "other x" and so on.
TableNames table_names(const std::vector<std::string_view>& header);

/// Returns the words of a header line without quotes. A tab, comma or semicolon separates names, or
/// else blanks do. Brackets after a blank belong to the name before: "x [m] y [m] z [m]".
std::vector<std::string_view> words_of_header(std::string_view line);

/// Joins words such as "[m]" to the name before them. In a line of units, "[m] [km / s]", each unit
/// becomes one word. The words must be parts of one line.
void join_units(std::vector<std::string_view>& words);

/// Takes units from a row of units, such as "m", "(m)", "[m/s]", one per name. Returns false, and
/// takes none, if the row has another number of fields, if the table has no positions, or if x, y
/// and z do not have the same known unit of length.
bool take_units(const std::vector<std::string_view>& row, TableNames& table);

/// Returns the unit of the positions. Empty: unknown. Throws InputError at `place` if x, y and z
/// have different units. The table must have positions.
std::string unit_of_positions(const TableNames& table, const FilePlace& place);

/// Returns the names, as in the table, of the two columns with sky coordinates: "ra" and "dec", or
/// galactic "glon" and "glat". Returns empty texts if there are no such columns.
std::array<std::string, 2> sky_angles(const TableNames& table);

/// Throws InputError at `place`, and says how to compute positions, if the table has sky
/// coordinates instead of positions.
void refuse_sky_coordinates(const TableNames& table, const FilePlace& place);

}  // namespace parray::input
