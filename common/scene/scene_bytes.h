#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

#include "common/scene/scene.h"

namespace parray::scene {

/// Bytes of a sphere: centre, radius, material. The largest part of a scene's bytes is usually its
/// list of spheres.
inline constexpr std::size_t scene_bytes_of_sphere = 4 * sizeof(double) + sizeof(std::uint32_t);
/// Bytes of a capsule: both ends, radius, material.
inline constexpr std::size_t scene_bytes_of_capsule = 7 * sizeof(double) + sizeof(std::uint32_t);

/// Returns whether kernels can trace the capsule: whether its ends are equal, or at least
/// 2 * limits::min_radius apart along some axis.
bool has_valid_ends(const Capsule& capsule);

/// Returns the only binary form of a scene. Workers receive it, and its SHA-256 is the scene's
/// identity. Equal scenes have equal bytes, independent of the file format that they were read
/// from. The form begins with "PRSCENE1" for a perspective camera and with "PRSCENE2" for an
/// orthographic one. "PRSCENE2" has view_height in the place of vfov, and no tan_half_vfov. A scene
/// with capsules has the same form with "PRSCENE3" (perspective) or "PRSCENE4" (orthographic), and
/// a list of capsules at the end. Older programs refuse the forms that they do not know.
std::string scene_to_bytes(const Scene& scene);

/// Reads the form of scene_to_bytes(). Checks every bound before it allocates, and every value that
/// kernels rely on. Throws DecodeError if a check fails.
Scene scene_from_bytes(std::string_view bytes);

/// Returns the SHA-256 of `scene_bytes`, the output of scene_to_bytes(), as 64 hexadecimal digits.
std::string scene_identity(std::string_view scene_bytes);
/// Returns scene_identity(scene_to_bytes(scene)) without making the bytes.
std::string scene_identity(const Scene& scene);

}  // namespace parray::scene
