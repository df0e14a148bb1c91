#pragma once

#include <cstdint>
#include <filesystem>

#include "common/scene/scene.h"
#include "tests/support/rooms.h"

namespace parray::bench {

/// Scenes from this size on are clouds; smaller ones are the One Weekend scene.
inline constexpr std::uint32_t smallest_cloud = 100'000;

/// `count` spheres at random in the unit ball, seen whole from outside under the default sky: a
/// tenth of the volume, radii that differ by a factor of 2, 50 materials (80 % of the spheres
/// diffuse, 15 % fuzzy metal, 5 % glass), in no order. A function of `count` alone.
///
/// A fair stand-in for atoms and grains: many alike, everywhere, some touching or overlapping, too
/// dense to see through. It flatters nobody who needs neighbours in the file to be neighbours in
/// space. Stars are sparser: there a ray passes more empty space, and more spheres are in sight.
Scene cloud(std::uint32_t count);

/// `count` sticks at random in the unit ball, like bonds without atoms: a twentieth of the volume,
/// six radii long between their ends, in all directions, of the materials of cloud() without glass,
/// because Embree's curves have no inside.
Scene sticks(std::uint32_t count);

/// The One Weekend scene from `folder`/one-weekend-COUNT.json, or cloud(count) from
/// `smallest_cloud` on. Throws InputError where the file cannot be read.
Scene scene_of_size(std::uint32_t count, const std::filesystem::path& folder);

}  // namespace parray::bench
