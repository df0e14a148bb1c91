#pragma once

#include "common/scene/limits.h"
#include "common/scene/number_range.h"

/// The ranges of a scene's numbers, which are the same in every format of scenes. Both ends belong
/// to a range.
namespace parray::scene::ranges {

inline constexpr NumberRange coordinate{-limits::max_length, limits::max_length};
inline constexpr NumberRange length{limits::min_radius, limits::max_length};
inline constexpr NumberRange aperture{0, limits::max_length};
/// In degrees. Below the range, the picture shows one point of the scene. Above it, the film is
/// more than 200 000 times as high as its distance from the eye.
inline constexpr NumberRange vfov{1e-6, 179.999};
inline constexpr NumberRange unit_interval{0, 1};  ///< albedo, fuzz
inline constexpr NumberRange ior{1e-3, 1e3};
inline constexpr NumberRange radiance{0, limits::max_radiance};
// Ranges of settings. A setting may also be 0, which means no limit.
inline constexpr NumberRange target_error{1e-9, 1e9};  ///< linear radiance
inline constexpr NumberRange time_limit{0.01, 1e7};    ///< seconds

}  // namespace parray::scene::ranges
