#pragma once

#include <cstddef>
#include <optional>
#include <string_view>

#include "common/scene/scene.h"

namespace parray::input {

/// An item of the section `spheres` in its usual form.
struct SphereText {
  Sphere sphere;              ///< `material` is not set
  std::string_view material;  ///< refers to the text
  std::size_t bytes = 0;      ///< from the start of the text to the end of the item
  std::size_t newlines = 0;   ///< number of newlines in these bytes
};

/// Reads the comma and the item at the start of `text`; skips blanks. The item is an object with
/// the keys center, radius and material, each once. Its numbers are in range, and its name is
/// printable ASCII without escapes. Returns nothing for other texts; the JSON parser then reads
/// them and reports errors.
std::optional<SphereText> next_sphere_text(std::string_view text);

}  // namespace parray::input
