#include "cli/input/particles/srgb8.h"

#include <array>
#include <cstddef>

#include "cli/output/picture/srgb.h"

namespace parray::input {
namespace {

std::array<double, 256> linear_values() {
  std::array<double, 256> values{};
  for (std::size_t i = 0; i < values.size(); ++i) {
    values[i] = srgb_decode(static_cast<double>(i) / 255);
  }
  return values;
}

}  // namespace

Vec3d linear_of_srgb8(const Vec3d& color) {
  static const std::array<double, 256> values = linear_values();
  return {values[static_cast<std::size_t>(color.x)], values[static_cast<std::size_t>(color.y)],
          values[static_cast<std::size_t>(color.z)]};
}

}  // namespace parray::input
