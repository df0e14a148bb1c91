#pragma once

#include <cstddef>

#include "common/rooms.h"

/// The inner loops of the filter: a weighted linear regression of the radiance around a pixel on
/// its features (cli/output/denoise/denoise.h). Compiled once for each instruction set, in its own
/// namespace. All give the same bits, because lanes do not interact.
namespace parray::denoise {

/// Half-width of the window: it has 9 x 9 pixels. A half-width of 3 takes a quarter less time and
/// leaves up to 18 % more error in pictures of molecules. One of 5 takes a third more time and
/// gains nothing.
inline constexpr int filter_reach = 4;
/// Half-width of the patches that are compared: they have 5 x 5 pixels.
inline constexpr int patch_reach = 2;
/// Number of pixels of a window.
inline constexpr int filter_offsets = (2 * filter_reach + 1) * (2 * filter_reach + 1);
/// Pixels filtered together; their data fits the cache of a core.
inline constexpr int tile_width = 32;
inline constexpr int tile_height = 16;
inline constexpr int tile_size = tile_width * tile_height;
inline constexpr int filter_features = 7;
/// Number of results of the filter with different smoothing, the less smooth one first.
inline constexpr int filter_grades = 2;

/// Pointers to pixel (0, 0) of planes with a margin (class Plane), with `stride` between rows.
struct FilterPlanes {
  int width = 0;
  int height = 0;
  std::ptrdiff_t stride = 0;
  const float* radiance[3] = {};              ///< of one half
  const float* noise = nullptr;               ///< mean square error of the half
  const float* own[filter_features] = {};     ///< features from the samples of the half
  const float* steady[filter_features] = {};  ///< steady features
  /// In image order, without a margin. Not 0: `out` gets the unfiltered radiance of the pixel.
  /// Null: all pixels are filtered.
  const char* plain = nullptr;
  float* out[filter_grades][3] = {};  ///< filtered radiance
};

/// Floats of scratch memory that a tile needs.
inline constexpr std::size_t filter_scratch = std::size_t{filter_offsets} * tile_size;

#define PARRAY_DECLARE_FILTER(isa)                                            \
  namespace isa {                                                             \
  /* Fills `out` in the tile whose first pixel is (x, y). */                  \
  /* x and y are multiples of tile_width and tile_height. */                  \
  /* Tile pixels beyond the picture may get any values. */                    \
  /* `scratch`: filter_scratch floats, which the function overwrites. */      \
  void filter_tile(const FilterPlanes& planes, int x, int y, float* scratch); \
  }

PARRAY_DECLARE_FILTER(scalar)
PARRAY_DECLARE_FILTER(avx2)
PARRAY_DECLARE_FILTER(avx512)
PARRAY_DECLARE_FILTER(neon)

#undef PARRAY_DECLARE_FILTER

}  // namespace parray::denoise
