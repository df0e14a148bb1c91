#pragma once

#include <cstddef>
#include <optional>
#include <string_view>

#include "common/scene/scene.h"

namespace parray::input {

/// An item of the section `spheres` as most files write it.
struct SphereText {
  Sphere sphere;              ///< `material` is not set
  std::string_view material;  ///< refers to the text
  std::size_t bytes = 0;      ///< of the text
  std::size_t newlines = 0;   ///< in them
};

/// The comma and the item that `text` starts with, blanks aside: an object of the keys center,
/// radius and material, each once, of numbers in range and a name of printable ASCII without
/// escapes. Nothing for all else, be it JSON or not: that takes the parser, which knows what to
/// say.
std::optional<SphereText> next_sphere_text(std::string_view text);

}  // namespace parray::input
