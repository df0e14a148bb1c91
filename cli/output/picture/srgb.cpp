#include "cli/output/picture/srgb.h"

#include <array>
#include <bit>
#include <cstddef>
#include <limits>

namespace parray::picture {
namespace {

/// Floats from `lowest`, below which the code is 0, to 1, in groups of like leading bits, each so
/// narrow that the code rises once in it at most.
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

  /// The first of the floats with bits in (first, last] that has a higher code than `first`.
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
    std::uint8_t code;  ///< of its first float
    float rise;         ///< where the next code begins; infinity: not in here
  };
  std::array<Group, group_count> groups_{};
};

}  // namespace

std::vector<std::uint8_t> srgb_bytes(std::span<const float> linear) {
  static const CodeTable table;
  std::vector<std::uint8_t> bytes(linear.size());
  std::transform(linear.begin(), linear.end(), bytes.begin(),
                 [](float value) { return table.code(value); });
  return bytes;
}

}  // namespace parray::picture
