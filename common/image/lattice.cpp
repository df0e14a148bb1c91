#include "common/image/lattice.h"

#include <algorithm>
#include <cstddef>

namespace parray::image {

std::vector<Lattice> nested_lattices(std::uint32_t width, std::uint32_t height) {
  constexpr std::uint64_t most_coarse = 4096;
  Lattice coarse;
  while (coarse.pixels(width, height) > most_coarse) coarse.step *= 2;
  std::vector<Lattice> lattices{coarse};
  for (std::uint32_t step = coarse.step; step > 1; step /= 2) {
    const std::uint32_t half = step / 2;
    for (const Lattice& lattice :
         {Lattice{half, half, step}, Lattice{half, 0, step}, Lattice{0, half, step}}) {
      if (lattice.pixels(width, height) > 0) lattices.push_back(lattice);
    }
  }
  return lattices;
}

BlockCorner block_corner(std::span<const std::uint32_t> samples, std::uint32_t width,
                         std::uint32_t x, std::uint32_t y) {
  BlockCorner corner{x, y, 1};
  while (samples[std::size_t{corner.y} * width + corner.x] == 0 && (corner.x > 0 || corner.y > 0)) {
    corner.block *= 2;
    corner.x = x / corner.block * corner.block;
    corner.y = y / corner.block * corner.block;
  }
  return corner;
}

Fill fill_untraced(Image& image, std::span<const std::uint32_t> samples) {
  Fill fill;
  std::size_t pixel = 0;
  for (std::uint32_t y = 0; y < image.height; ++y) {
    for (std::uint32_t x = 0; x < image.width; ++x, ++pixel) {
      if (samples[pixel] > 0) continue;
      const BlockCorner corner = block_corner(samples, image.width, x, y);
      const std::size_t from = std::size_t{corner.y} * image.width + corner.x;
      std::copy_n(image.rgb.begin() + static_cast<std::ptrdiff_t>(3 * from), 3,
                  image.rgb.begin() + static_cast<std::ptrdiff_t>(3 * pixel));
      ++fill.pixels;
      fill.block = std::max(fill.block, corner.block);
    }
  }
  return fill;
}

}  // namespace parray::image
