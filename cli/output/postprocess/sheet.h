#pragma once

#include <cstdint>
#include <vector>

#include "cli/output/postprocess/postprocessing.h"
#include "common/image/image.h"

/// Several pictures of one size in one.
namespace parray::postprocess {

/// Rows from the top, each from the left; the last may have fewer.
struct SheetLayout {
  std::uint32_t columns = 1;
  std::uint32_t rows = 1;
  std::uint32_t gap = 0;  ///< pixels between two pictures
};

/// Of `count` pictures (> 0): as many columns as make the sheet nearest to 2 by 1, empty places
/// counting against it; gaps of a 200th of a picture's height, and at least 2 pixels.
SheetLayout sheet_layout(std::size_t count, std::uint32_t width, std::uint32_t height);

/// Side of a sheet, beyond 32 bits where that many pictures are too many.
std::uint64_t sheet_width(const SheetLayout& layout, std::uint32_t width);
std::uint64_t sheet_height(const SheetLayout& layout, std::uint32_t height);

/// Pictures of one size side by side, as they are; white between them and where there is none, and
/// under what is transparent.
Image sheet_of(const std::vector<ShownPicture>& pictures, const SheetLayout& layout);

}  // namespace parray::postprocess
