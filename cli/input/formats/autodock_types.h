#pragma once

#include <cstdint>
#include <string_view>

#include "common/rooms.h"

namespace parray::input {

/// The element of a type of atom of AutoDock and Vina; 0 for the pseudo-atoms G and CG that glue
/// rings, and for what is no type. Source: AutoDock 4.2 User Guide, appendix "Parameters"; for W
/// (water of hydrated docking) and the types of rings, the manual of Meeko
/// (meeko.readthedocs.io).
std::uint8_t element_of_autodock_type(std::string_view type);

}  // namespace parray::input
