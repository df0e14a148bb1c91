#pragma once

#include <cstddef>
#include <cstdint>

#include "common/rooms.h"

/// The inner loops of the filter: a weighted linear regression of the radiance around a pixel on
/// its features, as cli/output/denoise/denoise.h describes it. Compiled once for each instruction
/// set, in a namespace of its own; the same bits from each, because no lane knows of another.
namespace parray::denoise {

/// How far the window reaches, and the patches that are compared.
inline constexpr int filter_reach = 4;
inline constexpr int patch_reach = 2;
/// (Reach 3 takes a quarter less time and leaves up to 18 % more error in pictures of molecules; 5
/// takes a third more and gains nothing.)
inline constexpr int filter_offsets = (2 * filter_reach + 1) * (2 * filter_reach + 1);
/// Pixels that are filtered together: what they need fits a core's cache.
inline constexpr int tile_width = 32;
inline constexpr int tile_height = 16;
inline constexpr int tile_size = tile_width * tile_height;
inline constexpr int filter_features = 7;
/// How many degrees of smoothing there are, the finer one first.
inline constexpr int filter_grades = 2;

/// Pointers are to pixel (0, 0) of planes with a margin (cli/output/denoise/plane.h), `stride`
/// apart from row to row.
struct FilterPlanes {
  int width = 0;
  int height = 0;
  std::ptrdiff_t stride = 0;
  const float* radiance[3] = {};              ///< of one half
  const float* noise = nullptr;               ///< mean square error of the half
  const float* own[filter_features] = {};     ///< features, as the half's samples have them
  const float* steady[filter_features] = {};  ///< features, as they are
  const char* plain = nullptr;  ///< by image row: pixels that stay as they are; null: none
  float* out[filter_grades][3] = {};
};

/// Floats of scratch memory that a tile needs.
inline constexpr std::size_t filter_scratch = std::size_t{filter_offsets} * tile_size;

#define PARRAY_DECLARE_FILTER(isa)                                                       \
  namespace isa {                                                                        \
  /* Fills `out` in the tile whose first pixel is (x, y), as far as the picture goes. */ \
  void filter_tile(const FilterPlanes& planes, int x, int y, float* scratch);            \
  }

PARRAY_DECLARE_FILTER(scalar)
PARRAY_DECLARE_FILTER(avx2)
PARRAY_DECLARE_FILTER(avx512)
PARRAY_DECLARE_FILTER(neon)

#undef PARRAY_DECLARE_FILTER

}  // namespace parray::denoise
