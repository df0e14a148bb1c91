#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "cli/input/color/legend.h"
#include "cli/input/color/number_bounds.h"
#include "cli/input/color/particle_coloring.h"
#include "cli/input/particles/particles.h"
#include "common/math/vec.h"

namespace parray::input {

/// Number of distinct colours of categories. Further categories repeat them.
inline constexpr std::size_t category_color_count = 24;

/// Returns the linear RGB of category `number`, from 0. The first seven colours are those of Okabe
/// and Ito ("Color Universal Design", 2008) without black, which shows no shape on a ball. Each
/// further colour comes from a grid in sRGB. It is the one that lies farthest, in Oklab, from all
/// previous colours and from the grey of unknown categories. The distance is the least of four
/// observers: normal colour vision, and the protanope, deuteranope and tritanope of Machado,
/// Oliveira and Fernandes ("A physiologically-based model for simulation of color vision
/// deficiency", IEEE TVCG 15(6), 2009).
Vec3d category_color(std::size_t number);

/// Returns the indices of the names, sorted as in a legend: numbers by value, then texts
/// alphabetically, then the empty name.
std::vector<std::size_t> reading_order(const std::vector<std::string>& names);

/// Returns a colour for each of the distinct names. If all are whole numbers from 1 to
/// category_color_count, such as types of LAMMPS, the name n has category_color(n - 1). Otherwise
/// the names have the colours 0, 1, 2 ... in reading_order(). So colours do not depend on the order
/// of the particles.
std::vector<Vec3d> colors_of_names(const std::vector<std::string>& names);

/// The name in legends of the category without a name.
inline constexpr std::string_view nameless_category = "no name";

/// Number of colours for numbers. It limits the number of materials. It is odd, so that the middle
/// of a map is one of the colours.
inline constexpr std::size_t color_levels = 1023;

/// A colour for each particle.
struct ParticleColors {
  std::vector<Vec3d> palette;        ///< linear RGB in [0, 1]
  std::vector<std::uint32_t> index;  ///< into `palette`, one per particle; empty: no colours
  Legend legend;
  /// Numbers at the ends of the map. Both ends may be equal, such as when all particles have the
  /// same number. Then the legend shows a wider scale. Empty: the colours are those of categories.
  NumberBounds numbers{};

  [[nodiscard]] bool empty() const { return index.empty(); }
};

/// Returns the colours of `particles`, at least one. `coloring` is not empty and has no
/// contradiction: see problem_with(). On a linear or logarithmic scale, adds notes to `particles`.
/// The note "unknown_numbers" counts particles without a number, and on a logarithmic scale those
/// without a positive number. The note "clipped" counts particles outside the range, which get the
/// colour of the nearer end. Infinite numbers are outside every range. The result is the same for
/// any number of threads.
///
/// An open end of the range is the least or largest number. The range is symmetric if both ends are
/// open, the map has a middle and numbers lie on both sides of 0. Percentiles are by nearest rank.
/// Open ends and percentiles ignore numbers that are unknown or infinite.
///
/// Throws UnknownNumber (selection.h) if `coloring.by` is a numeric column that the particles lack.
/// Throws SourceError (file_place.h) in the following cases:
/// - "color_by": the particles lack the column, or no number can be an end of the scale.
/// - "color_scale": `categories` would have more than 1000 different numbers.
/// - "range": the low end is above the high end for these particles, or not above 0 on a
///   logarithmic scale.
ParticleColors colors_of(const ParticleColoring& coloring, Particles& particles, int threads = 1);

}  // namespace parray::input
