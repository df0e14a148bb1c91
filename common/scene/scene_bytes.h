#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

#include "common/scene/scene.h"

namespace parray::scene {

/// Centre, radius, material: the last and largest part of a scene's bytes is a list of these.
inline constexpr std::size_t scene_bytes_of_sphere = 4 * sizeof(double) + sizeof(std::uint32_t);

/// The scene's one binary form: what travels to workers, and what its identity is the SHA-256 of.
/// Equal scenes have equal bytes, whichever file format they were read from. A scene of a
/// perspective camera begins with "PRSCENE1", one of an orthographic camera, which programs without
/// that camera refuse, with "PRSCENE2": view_height stands in the place of vfov, and no tangent.
std::string scene_to_bytes(const Scene& scene);

/// Inverse of scene_to_bytes. Checks every bound before it allocates and every value that the
/// kernel relies on. Throws DecodeError.
Scene scene_from_bytes(std::string_view bytes);

/// SHA-256 of scene_to_bytes(scene), 64 hexadecimal digits.
std::string scene_identity(std::string_view scene_bytes);
/// The same without making them.
std::string scene_identity(const Scene& scene);

}  // namespace parray::scene
