#pragma once

#include "cli/input/particles/particles.h"
#include "common/math/vec.h"

namespace parray::input {

/// Returns the cell at the origin with edges of these lengths (> 0) and the angles alpha (between b
/// and c), beta (a and c) and gamma (a and b) in degrees. a lies along x, b in the xy plane
/// (International Tables for Crystallography, volume B, section 3.3.1). Returns nothing if no cell
/// has these lengths and angles, or if a length is above limits::max_length.
std::optional<ParticleCell> cell_from(const Vec3d& lengths, const Vec3d& angles);

/// Returns `cell`, or nothing if the cell has no volume or is not finite.
std::optional<ParticleCell> valid_cell(const ParticleCell& cell);

}  // namespace parray::input
