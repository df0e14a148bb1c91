#pragma once

#include <cstdint>
#include <string_view>

#include "common/math/vec.h"

namespace parray::input {

/// A chemical element as molecular pictures show it.
struct Element {
  std::string_view symbol;
  double radius;  ///< van der Waals radius, angstrom
  Vec3d color;    ///< linear RGB in [0, 1]
};

inline constexpr std::uint8_t last_element = 118;

/// By atomic number; 0, or a number beyond the table, is "unknown" with radius and colour of its
/// own.
const Element& element(std::uint8_t atomic_number);

/// Atomic number of a symbol, whatever its case ("CL", "cl", "Cl"); D and T are hydrogen; 0 if it
/// is none.
std::uint8_t atomic_number_of(std::string_view symbol);

}  // namespace parray::input
