#pragma once

#include <cstddef>
#include <cstdint>

#include "common/rooms.h"

/// Bounds that every reader and decoder checks before it allocates.
namespace parray::scene::limits {

inline constexpr std::uint32_t max_image_side = 1U << 16;            ///< pixels
inline constexpr std::uint64_t max_pixels = std::uint64_t{1} << 26;  ///< 4.5 GiB of sums
inline constexpr std::uint32_t max_samples_per_pixel = 1U << 24;
inline constexpr std::uint32_t max_depth = 1U << 20;           ///< ray segments of a path
inline constexpr std::size_t max_passes = 1000;                ///< in StopSettings::passes
inline constexpr std::uint64_t max_shapes = 100'000'000;       ///< spheres and capsules of a scene
inline constexpr std::uint64_t max_materials = 1U << 24;       ///< of a scene
inline constexpr std::uint64_t max_particle_files = 1U << 16;  ///< that a scene file names
/// Largest size of a scene file or particle file after unpacking.
inline constexpr std::uint64_t max_scene_file_bytes = std::uint64_t{16} << 30;
inline constexpr std::size_t max_json_depth = 16;  ///< nested objects and lists of a scene file
inline constexpr std::uint32_t max_frame = 999'999'999;  ///< number of a frame
inline constexpr std::uint32_t max_frames = 10'000;      ///< of one series
/// Coordinates, radii and camera lengths have magnitudes up to this, in the scene's unit. So
/// squares and sums of squares stay finite in single precision.
inline constexpr double max_length = 1e15;
inline constexpr double min_radius = 1e-15;  ///< also the least focus distance and view height
/// Largest component of the sky's radiance.
inline constexpr double max_radiance = 1e6;

}  // namespace parray::scene::limits

namespace parray::scene {

// Both ends belong to a range.
struct NumberRange {
  double least;
  double most;
};
struct IntegerRange {
  std::uint64_t least;
  std::uint64_t most;
};

}  // namespace parray::scene

/// The ranges of a scene's numbers, which are the same in every format of scenes.
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
