#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "cli/input/particles/particles.h"

/// The columns of particles as selections and messages call them.
namespace parray::input {

/// Of the words "type", "name", "resname" and "chain".
const NameColumn& name_column(std::string_view word, const Particles& particles);

/// "chains" for "chain"; of the words of name_column().
std::string plural_of(std::string_view word);

/// "particle" or "particles", which stands behind that number.
inline std::string particles_word(std::uint64_t count) {
  return count == 1 ? "particle" : "particles";
}

/// The columns that particles have: "elements, types and z"; positions are not spoken of.
std::string columns_of(const Particles& particles);

}  // namespace parray::input
