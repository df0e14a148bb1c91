#pragma once

#include <cstdint>
#include <string_view>
#include <utility>
#include <vector>

#include "cli/input/particles/particles.h"
#include "common/base/text.h"

/// Notes on values that readers guess, and on what they leave out or pictures do not show.
namespace parray::input {

/// Adds a note, unless its count is 0.
inline void add_note(std::vector<ParticleNote>& notes, ParticleNote note) {
  if (note.count > 0) notes.push_back(std::move(note));
}

/// Returns the note "COUNT ellipsoids shown as spheres".
inline ParticleNote ellipsoids_note(std::uint64_t count) {
  return {"ellipsoids", count,
          in_number(count, "ellipsoid shown as a sphere", "ellipsoids shown as spheres")};
}

/// Returns whether three diameters are not all equal. Returns false unless all are numbers.
inline bool is_ellipsoid(std::string_view x, std::string_view y, std::string_view z) {
  const auto a = number_in(x);
  const auto b = number_in(y);
  const auto c = number_in(z);
  return a && b && c && (*a != *b || *b != *c);
}

}  // namespace parray::input
