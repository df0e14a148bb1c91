#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "common/rooms.h"

namespace parray::input {

/// The columns of a section Atoms in a LAMMPS data file, by the names of layout_of(): LAMMPS
/// manual, "read_data", table of atom styles. Image flags may follow them. Empty: the style is not
/// known, or has no fixed columns.
std::vector<std::string> lammps_style_columns(std::string_view style);

/// The style that a row without a hint is likely to be of, by how many columns it has and what is
/// in them; empty: none. `types`: how many atom types the file has.
std::string_view lammps_style_of(const std::vector<std::string_view>& row, std::uint64_t types);

}  // namespace parray::input
