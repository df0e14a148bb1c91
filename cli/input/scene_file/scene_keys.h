#pragma once

#include <array>
#include <string_view>

#include "common/rooms.h"

namespace parray::input {

/// The keys at the top level of a scene file.
inline constexpr std::array<std::string_view, 12> scene_keys{
    "version",   "camera",    "image",   "render",   "style",     "sky",
    "finishing", "materials", "spheres", "capsules", "particles", "labels"};

}  // namespace parray::input
