#pragma once

#include <cstdint>
#include <vector>

#include "cli/input/particles/file_place.h"
#include "cli/input/particles/particles.h"

/// What binary trajectories share.
namespace parray::input {

inline constexpr double angstrom_per_nm = 10;

/// `count` as a number of particles; fails beyond limits::max_spheres, and for a negative one.
std::uint64_t checked_atoms(std::int64_t count, const FilePlace& place);

/// A frame with these positions and nothing else; fails where one is out of range.
Particles frame_of(const std::vector<Vec3d>& positions, const FilePlace& place);

/// Says that lengths in nm have become angstrom.
ParticleNote nm_note(const Particles& particles);

}  // namespace parray::input
