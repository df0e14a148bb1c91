#pragma once

#include "cli/input/particles/particles.h"
#include "common/math/vec.h"

namespace parray::input {

/// The cell at the origin with edges of these lengths (> 0) and the angles alpha (between b and c),
/// beta (a and c) and gamma (a and b) in degrees: a along x, b in the xy plane, as crystallography
/// has it (International Tables for Crystallography, volume B, section 3.3.1). Nothing where the
/// lengths or angles make no cell.
std::optional<ParticleCell> cell_from(const Vec3d& lengths, const Vec3d& angles);

/// `cell`, or nothing where its edges span no volume, or it is not finite.
std::optional<ParticleCell> valid_cell(const ParticleCell& cell);

}  // namespace parray::input
