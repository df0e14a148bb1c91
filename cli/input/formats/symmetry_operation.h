#pragma once

#include <array>
#include <optional>
#include <string_view>

#include "common/rooms.h"

namespace parray::input {

/// Fractions to fractions: three rows of a 3 x 3 matrix, each with its translation behind it.
using SymmetryOperation = std::array<double, 12>;

/// "x, y+1/2, -z", "-Y,X-Y,Z+0.333", as International Tables for Crystallography, volume A, write
/// operations; nothing for any other text.
std::optional<SymmetryOperation> symmetry_operation_in(std::string_view text);

}  // namespace parray::input
