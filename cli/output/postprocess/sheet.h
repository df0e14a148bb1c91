#pragma once

#include <cstdint>
#include <vector>

#include "cli/output/postprocess/postprocessing.h"
#include "common/image/image.h"

/// Several pictures of the same size in one.
namespace parray::postprocess {

/// Pictures in rows, from the top left. The last row may have fewer.
struct SheetLayout {
  std::uint32_t columns = 1;
  std::uint32_t rows = 1;
  std::uint32_t gap = 0;  ///< pixels between two pictures
};

/// Returns the layout of `count` pictures (> 0) of `width` x `height` pixels. The number of columns
/// is a compromise between a sheet twice as wide as high and few empty places. Gaps are 1/200 of a
/// picture's height, at least 2 pixels.
SheetLayout sheet_layout(std::size_t count, std::uint32_t width, std::uint32_t height);

/// Return the size of a sheet in pixels, which may exceed 32 bits. `width`, `height`: of a picture.
std::uint64_t sheet_width(const SheetLayout& layout, std::uint32_t width);
std::uint64_t sheet_height(const SheetLayout& layout, std::uint32_t height);

/// Joins pictures of the same size. The gaps, empty places and transparent pixels are white.
Image sheet_of(const std::vector<ShownPicture>& pictures, const SheetLayout& layout);

}  // namespace parray::postprocess
