#pragma once

#include <cstddef>
#include <cstdint>
#include <string_view>
#include <vector>

#include "cli/input/color/legend.h"
#include "cli/input/color/particle_coloring.h"
#include "cli/input/particles/particles.h"
#include "common/math/vec.h"

namespace parray::input {

/// Number of distinct colours; then they repeat.
inline constexpr std::size_t category_color_count = 24;

/// Returns the linear RGB of a category by its number. The first seven are Okabe and Ito's ("Color
/// Universal Design", 2008; without black, which shows no shape on a ball). Each further colour is
/// the one of a grid in sRGB that lies farthest, in Oklab, from all before it and from the grey of
/// unknown categories. The nearest of four observers counts: normal colour vision, and Machado,
/// Oliveira and Fernandes's protanope, deuteranope and tritanope ("A physiologically-based model
/// for simulation of color vision deficiency", IEEE TVCG 15(6), 2009).
Vec3d category_color(std::size_t number);

/// The grey of particles without a category.
inline constexpr Vec3d no_category_color{0.5, 0.5, 0.5};

/// Number of colours for numbers, so that materials stay few. It is odd, so that the middle of a
/// map is one of them.
inline constexpr std::size_t color_levels = 1023;

/// A colour for each particle.
struct ParticleColors {
  std::vector<Vec3d> palette;        ///< linear RGB in [0, 1]
  std::vector<std::uint32_t> index;  ///< into `palette`, one per particle; empty: no colours
  Legend legend;

  [[nodiscard]] bool empty() const { return index.empty(); }
};

/// Colours `particles`, at least one. Notes count particles without a number ("unknown_numbers")
/// and those outside the range, which get the colour of its end ("clipped"). The result is the same
/// for any number of threads.
///
/// An open end of the range is the least or largest number. If both ends are open, the map has a
/// middle and numbers lie on both sides of 0, the range is symmetric. Percentiles are by nearest
/// rank.
///
/// Throws SourceError for a member of the coloring, UnknownNumber for its `by`.
ParticleColors colors_of(const ParticleColoring& coloring, Particles& particles, int threads = 1);

}  // namespace parray::input
