#pragma once

#include <cstdint>
#include <string_view>

#include "common/math/vec.h"

namespace parray::input {

/// A chemical element and its usual look in pictures of molecules.
struct Element {
  std::string_view symbol;
  double radius;  ///< van der Waals radius, angstrom
  Vec3d color;    ///< linear RGB in [0, 1]
};

inline constexpr std::uint8_t last_element = 118;

/// Returns an element by its atomic number. 0 and numbers above last_element give the unknown
/// element, which has the symbol "X" and its own radius and colour.
const Element& element(std::uint8_t atomic_number);

/// Returns the atomic number of a symbol in any letter case ("CL", "cl", "Cl"). Returns 0 for other
/// texts. D and T are hydrogen.
std::uint8_t atomic_number_of(std::string_view symbol);

}  // namespace parray::input
