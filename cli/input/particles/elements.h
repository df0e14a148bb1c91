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

/// Returns the covalent radius of an element by its atomic number, in angstrom. Cordero and others,
/// "Covalent radii revisited", Dalton Trans. (2008) 2832: C is sp3; Mn, Fe and Co have low spin.
/// The table ends at Cm, whose radius all later elements have. 0 (unknown) has the radius of
/// carbon.
double covalent_radius(std::uint8_t atomic_number);

/// Returns the radius of an element in a crystal, in angstrom. Metals: the metallic radius for
/// coordination number 12, from Greenwood and Earnshaw, "Chemistry of the Elements", 2nd edition
/// (1997). Elements without a metallic radius in these tables, such as nonmetals, Si, Sn and Bi:
/// the covalent radius.
double crystal_radius(std::uint8_t atomic_number);

/// Returns whether crystal_radius() of an element is a metallic radius.
bool is_metal(std::uint8_t atomic_number);

/// Returns whether an element is a noble gas: group 18.
bool is_noble_gas(std::uint8_t atomic_number);

/// Returns whether an element forms ions rather than bonds in most compounds: groups 1 and 2
/// without hydrogen.
bool is_ionic(std::uint8_t atomic_number);

}  // namespace parray::input
