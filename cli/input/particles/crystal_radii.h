#pragma once

#include <cstdint>

namespace parray::input {

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
