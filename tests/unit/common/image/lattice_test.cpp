#include "common/image/lattice.h"

#include <doctest/doctest.h>

#include <cstddef>
#include <vector>

#include "tests/support/rooms.h"

namespace parray::test {
namespace {

struct Size {
  std::uint32_t width;
  std::uint32_t height;
};

constexpr Size sizes[] = {{1, 1}, {64, 64}, {65, 64}, {600, 400}, {1201, 7}, {1, 5000}, {333, 777}};

/// Of each pixel, how many of the lattices have it.
std::vector<std::uint32_t> covered(const Size& size, std::size_t lattices) {
  std::vector<std::uint32_t> counts(std::size_t{size.width} * size.height);
  const auto all = nested_lattices(size.width, size.height);
  for (std::size_t i = 0; i < lattices; ++i) {
    for (std::uint32_t y = all[i].y; y < size.height; y += all[i].step) {
      for (std::uint32_t x = all[i].x; x < size.width; x += all[i].step) {
        ++counts[std::size_t{y} * size.width + x];
      }
    }
  }
  return counts;
}

std::uint64_t pixels_of(const Size& size) { return std::uint64_t{size.width} * size.height; }

}  // namespace

TEST_CASE("nested lattices share no pixel, leave none out, and the first is small") {
  for (const Size& size : sizes) {
    const auto lattices = nested_lattices(size.width, size.height);
    CHECK(covered(size, lattices.size()) == std::vector<std::uint32_t>(pixels_of(size), 1));
    CHECK(lattices.front().pixels(size.width, size.height) <= 4096);
    std::uint64_t pixels = 0;
    for (const Lattice& lattice : lattices) {
      CHECK(lattice.pixels(size.width, size.height) > 0);
      pixels += lattice.pixels(size.width, size.height);
    }
    CHECK(pixels == pixels_of(size));
  }
}

TEST_CASE("a pixel without a sample shows the corner of the smallest block that has one") {
  const Size size{200, 100};
  const auto lattices = nested_lattices(size.width, size.height);
  for (std::size_t traced = 1; traced <= lattices.size(); ++traced) {
    const auto counts = covered(size, traced);
    Image image{size.width, size.height, std::vector<float>(3 * pixels_of(size), -1)};
    for (std::size_t i = 0; i < counts.size(); ++i) {
      if (counts[i] > 0) image.rgb[3 * i] = static_cast<float>(i);
    }
    const Fill fill = fill_untraced(image, counts);
    std::uint64_t filled = 0;
    for (std::uint32_t y = 0; y < size.height; ++y) {
      for (std::uint32_t x = 0; x < size.width; ++x) {
        const std::size_t pixel = std::size_t{y} * size.width + x;
        const BlockCorner corner = block_corner(counts, size.width, x, y);
        const std::size_t from = std::size_t{corner.y} * size.width + corner.x;
        REQUIRE(counts[from] == 1);
        REQUIRE(image.rgb[3 * pixel] == static_cast<float>(from));
        REQUIRE(corner.block <= fill.block);
        REQUIRE(x - corner.x < corner.block);
        REQUIRE(y - corner.y < corner.block);
        // A smaller block has no sample at its corner.
        if (corner.block > 1) {
          const std::uint32_t half = corner.block / 2;
          REQUIRE(counts[std::size_t{y / half * half} * size.width + x / half * half] == 0);
        }
        filled += counts[pixel] == 0 ? 1 : 0;
      }
    }
    CHECK(fill.pixels == filled);
    CHECK(fill.block <= lattices.front().step);
    CHECK((fill.pixels > 0) == (fill.block > 1));
  }
}

TEST_CASE("an image without a sample is filled with its first pixel") {
  Image image{70, 3, std::vector<float>(70 * 3 * 3, 0)};
  CHECK(fill_untraced(image, std::vector<std::uint32_t>(70 * 3)).pixels == 70 * 3);
}

}  // namespace parray::test
