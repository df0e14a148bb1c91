#include "cli/output/picture/srgb.h"

#include <array>
#include <bit>
#include <cstddef>
#include <limits>

namespace parray::picture {
namespace {

/// A table of codes. Floats from `lowest` (below, the code is 0) to 1 form groups with equal
/// leading bits. In each group, the code rises at most once.
class CodeTable {
 public:
  CodeTable() {
    for (std::uint32_t group = 0; group < groups_.size(); ++group) {
      const std::uint32_t first = lowest_bits + (group << shift);
      const std::uint32_t last = first + (1U << shift) - 1;
      groups_[group] = {srgb_byte(std::bit_cast<float>(first)), rise(first, last)};
    }
  }

  [[nodiscard]] std::uint8_t code(float linear) const {
    if (!(linear >= lowest)) return 0;
    if (linear >= 1) return 255;
    const std::uint32_t bits = std::bit_cast<std::uint32_t>(linear);
    const Group& group = groups_[(bits - lowest_bits) >> shift];
    return static_cast<std::uint8_t>(group.code + (linear >= group.rise ? 1 : 0));
  }

 private:
  static constexpr float lowest = 0x1p-13F;
  static constexpr auto lowest_bits = std::bit_cast<std::uint32_t>(lowest);
  static constexpr unsigned shift = 16;
  static constexpr std::size_t group_count =
      (std::bit_cast<std::uint32_t>(1.0F) - lowest_bits) / (1U << shift);

  /// Returns the first float with bits in (first, last] that has a higher code than `first`.
  static float rise(std::uint32_t first, std::uint32_t last) {
    const auto code = [](std::uint32_t bits) { return srgb_byte(std::bit_cast<float>(bits)); };
    const std::uint8_t before = code(first);
    if (code(last) == before) return std::numeric_limits<float>::infinity();
    while (last - first > 1) {
      const std::uint32_t middle = first + (last - first) / 2;
      (code(middle) == before ? first : last) = middle;
    }
    return std::bit_cast<float>(last);
  }

  struct Group {
    std::uint8_t code;  ///< code of the first float
    float rise;         ///< float at which the next code begins; infinity: not in this group
  };
  std::array<Group, group_count> groups_{};
};

std::array<double, 256> linear_values() {
  std::array<double, 256> values{};
  for (std::size_t i = 0; i < values.size(); ++i) {
    values[i] = srgb_decode(static_cast<double>(i) / 255);
  }
  return values;
}

}  // namespace

std::vector<std::uint8_t> srgb_bytes(std::span<const float> linear) {
  static const CodeTable table;
  std::vector<std::uint8_t> bytes(linear.size());
  std::ranges::transform(linear, bytes.begin(), [](float value) { return table.code(value); });
  return bytes;
}

Vec3d linear_of_srgb8(const Vec3d& color) {
  static const std::array<double, 256> values = linear_values();
  return {values[static_cast<std::size_t>(color.x)], values[static_cast<std::size_t>(color.y)],
          values[static_cast<std::size_t>(color.z)]};
}

Vec3d linear_of_code(std::uint32_t code) {
  const auto channel = [code](int shift) { return static_cast<double>((code >> shift) & 0xFFU); };
  return linear_of_srgb8({channel(16), channel(8), channel(0)});
}

}  // namespace parray::picture
