#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "common/image/image.h"

namespace parray::image {

/// A lattice of pixels: every `step`-th pixel in x and in y, starting at (x, y).
struct Lattice {
  std::uint32_t x = 0;     ///< < step
  std::uint32_t y = 0;     ///< < step
  std::uint32_t step = 1;  ///< > 0

  /// Return the number of the lattice's pixels across an image of this width, and down an image of
  /// this height.
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

/// Returns lattices that share no pixel and together cover an image, coarse ones first. So the
/// first lattices, however many, are spread evenly. The first one has at most 4096 pixels. Then
/// follow up to three for each halving of the step. The first of these has its pixels in the middle
/// of the squares that the lattices before form. No lattice is empty.
std::vector<Lattice> nested_lattices(std::uint32_t width, std::uint32_t height);

/// The filling of pixels without a sample.
struct Fill {
  std::uint64_t pixels = 0;  ///< filled pixels; 0: every pixel has a sample
  std::uint32_t block = 1;   ///< side of the largest block that one traced pixel fills, in pixels
};

/// The traced pixel that stands for pixel (x, y): the pixel itself, or the corner (the top left
/// pixel) of the smallest block around it whose corner has been traced. Blocks have sides of 2, 4,
/// 8 ... and start at multiples of their side. (0, 0) if no such corner has been traced.
struct BlockCorner {
  std::uint32_t x = 0;
  std::uint32_t y = 0;
  std::uint32_t block = 1;  ///< side of the block, in pixels
};
/// Returns the corner that stands for pixel (x, y). `samples` holds the number of samples of each
/// pixel, in image order.
BlockCorner block_corner(std::span<const std::uint32_t> samples, std::uint32_t width,
                         std::uint32_t x, std::uint32_t y);

/// Gives every pixel without a sample the value of its block_corner(). `samples` holds the number
/// of samples of each pixel, in image order.
Fill fill_untraced(Image& image, std::span<const std::uint32_t> samples);

}  // namespace parray::image
