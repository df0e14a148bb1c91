#include "cli/output/picture/srgb.h"

#include <doctest/doctest.h>

#include <bit>
#include <cstddef>
#include <limits>
#include <vector>

#include "tests/support/dice.h"
#include "tests/support/rooms.h"

namespace parray {
namespace {

void check_codes(const std::vector<float>& values) {
  const std::vector<std::uint8_t> bytes = srgb_bytes(values);
  REQUIRE(bytes.size() == values.size());
  std::size_t wrong = 0;
  for (std::size_t i = 0; i < values.size(); ++i) wrong += bytes[i] == srgb_byte(values[i]) ? 0 : 1;
  CHECK(wrong == 0);
}

TEST_CASE("the table has the right code for floats next to another code") {
  std::vector<float> values;
  for (int code = 0; code < 255; ++code) {
    // The first float of the next code, by halving; bits of positive floats are ordered as they
    // are.
    std::uint32_t below = 0;
    auto above = std::bit_cast<std::uint32_t>(1.0F);
    while (above - below > 1) {
      const std::uint32_t middle = below + (above - below) / 2;
      (srgb_byte(std::bit_cast<float>(middle)) <= code ? below : above) = middle;
    }
    for (std::uint32_t bits = above - 3; bits != above + 3; ++bits) {
      values.push_back(std::bit_cast<float>(bits));
    }
  }
  check_codes(values);
}

TEST_CASE("the table has the right codes for floats of all sizes and for NaN") {
  constexpr float infinite = std::numeric_limits<float>::infinity();
  std::vector<float> values{0,
                            -0.0F,
                            1,
                            1.5F,
                            -1,
                            infinite,
                            -infinite,
                            std::numeric_limits<float>::denorm_min(),
                            std::numeric_limits<float>::quiet_NaN()};
  test::Dice dice(1);
  for (int i = 0; i < 1'000'000; ++i) {
    values.push_back(std::bit_cast<float>(dice.below32(std::bit_cast<std::uint32_t>(2.0F))));
    values.push_back(static_cast<float>(dice.below32(1U << 24)) * 0x1p-24F);
  }
  check_codes(values);
}

}  // namespace
}  // namespace parray
