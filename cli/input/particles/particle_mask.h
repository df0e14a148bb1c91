#pragma once

#include <cstdint>
#include <vector>

#include "cli/input/particles/particles.h"

namespace parray::input {

/// One byte a particle: 1 or 0.
using ParticleMask = std::vector<std::uint8_t>;

/// Leaves only the particles of the mask, in their order.
void keep(Particles& particles, const ParticleMask& mask);

}  // namespace parray::input
