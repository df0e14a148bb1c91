#include "cli/input/color/category_colors.h"

#include <array>
#include <cstdint>

#include "cli/output/picture/srgb.h"

namespace parray::input {
namespace {

constexpr std::array<Vec3d, 7> okabe_ito{{
    {0.7913, 0.3467, 0.0},     // orange
    {0.0931, 0.4564, 0.8148},  // sky blue
    {0.0, 0.3419, 0.1714},     // bluish green
    {0.8714, 0.7758, 0.0545},  // yellow
    {0.0, 0.1683, 0.4452},     // blue
    {0.6654, 0.1119, 0.0},     // vermilion
    {0.6038, 0.1912, 0.3864},  // reddish purple
}};

/// Those that follow, in sRGB.
constexpr std::array<std::uint32_t, category_color_count - okabe_ito.size()> grid_colors{
    0x882808, 0xa0ffd0, 0x385068, 0xa068ff, 0x7000a0, 0x7808f0, 0xa84838, 0x58d8ff, 0x886078,
    0xa8e098, 0x88b878, 0xc828c0, 0xf0c048, 0xd0f898, 0xe87838, 0x8090e8, 0x903088};

}  // namespace

Vec3d category_color(std::size_t number) {
  number %= category_color_count;
  if (number < okabe_ito.size()) return okabe_ito[number];
  const std::uint32_t code = grid_colors[number - okabe_ito.size()];
  const auto component = [code](unsigned shift) {
    return srgb_decode(static_cast<double>((code >> shift) & 0xffU) / 255);
  };
  return {component(16), component(8), component(0)};
}

}  // namespace parray::input
