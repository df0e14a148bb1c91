#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "common/image/image.h"

namespace parray::image {

/// Every `step`-th pixel in x and in y, from (x, y) on.
struct Lattice {
  std::uint32_t x = 0;     ///< < step
  std::uint32_t y = 0;     ///< < step
  std::uint32_t step = 1;  ///< > 0

  /// How many there are across an image of that width; down one of that height.
  [[nodiscard]] std::uint32_t across(std::uint32_t width) const { return count(x, width); }
  [[nodiscard]] std::uint32_t down(std::uint32_t height) const { return count(y, height); }
  [[nodiscard]] std::uint64_t pixels(std::uint32_t width, std::uint32_t height) const {
    return std::uint64_t{across(width)} * down(height);
  }

  friend bool operator==(const Lattice&, const Lattice&) = default;

 private:
  [[nodiscard]] std::uint32_t count(std::uint32_t first, std::uint32_t side) const {
    return first < side ? (side - first - 1) / step + 1 : 0;
  }
};

/// Lattices that share no pixel and make up an image, coarse ones first, so that any number of them
/// from the start is spread evenly: one of at most 4096 pixels, then three for each halving of the
/// step (the one in the middle of its squares first). None is empty.
std::vector<Lattice> nested_lattices(std::uint32_t width, std::uint32_t height);

/// What stands in for pixels without a sample.
struct Fill {
  std::uint64_t pixels = 0;  ///< that are filled; 0: the picture needs none
  std::uint32_t block = 1;   ///< side of the largest block that one traced pixel fills, in pixels
};

/// The traced pixel that pixel (x, y) shows: itself, or else the corner of the smallest block of
/// side 2, 4, 8 ..., placed at multiples of its side, that has been traced. (0, 0) if none has.
/// `samples`: of each pixel, image order.
struct BlockCorner {
  std::uint32_t x = 0;
  std::uint32_t y = 0;
  std::uint32_t block = 1;  ///< side of the block, in pixels
};
BlockCorner block_corner(std::span<const std::uint32_t> samples, std::uint32_t width,
                         std::uint32_t x, std::uint32_t y);

/// Gives every pixel without a sample the value of its block's corner.
Fill fill_untraced(Image& image, std::span<const std::uint32_t> samples);

}  // namespace parray::image
