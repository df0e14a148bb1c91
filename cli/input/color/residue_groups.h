#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string_view>

#include "common/rooms.h"

namespace parray::input {

/// Residues that are alike in what they do to a molecule, in the order of their category_color().
std::span<const std::string_view> residue_groups();

/// Where a residue of that name stands in residue_groups(); nothing: in none.
std::optional<std::size_t> residue_group(std::string_view residue_name);

}  // namespace parray::input
