#pragma once

#include <cstdint>
#include <vector>

#include "cli/input/color/legend.h"
#include "cli/input/color/particle_coloring.h"
#include "cli/input/particles/particles.h"

namespace parray::input {

/// Numbers are shown in so many colours, so that materials stay few. Odd: the middle is one.
inline constexpr std::size_t color_levels = 1023;

/// A colour for each particle.
struct ParticlePaint {
  std::vector<Vec3d> colors;         ///< linear RGB in [0, 1]
  std::vector<std::uint32_t> index;  ///< one a particle, into `colors`; none: there is no paint
  Legend legend;

  [[nodiscard]] bool empty() const { return index.empty(); }
};

/// Colours `particles`, of which there is one at least. What has no number is noted with them
/// ("unknown_numbers"), so is what lies outside the range and has the colour of its end
/// ("clipped"). The same for any number of threads.
///
/// A range that is open goes to the least or largest number; that of a map with a middle, both ends
/// open and numbers on both sides of 0, is as wide on either side. Percentiles are by nearest rank.
///
/// Throws SourceError for a member of the coloring, UnknownNumber for its `by`.
ParticlePaint painted(const ParticleColoring& coloring, Particles& particles, int threads = 1);

}  // namespace parray::input
