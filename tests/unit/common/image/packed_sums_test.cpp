#include "common/image/packed_sums.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "common/base/bytes.h"
#include "tests/support/dice.h"
#include "tests/support/rooms.h"

namespace parray {
namespace {

using test::Dice;
using Pixels = std::vector<PixelSums>;

constexpr std::uint64_t most = std::numeric_limits<std::uint64_t>::max();

std::string packed(const Pixels& pixels) {
  std::string bytes;
  pack_sums(pixels, bytes);
  return bytes;
}

/// `count` pixels from all of `bytes`; nothing if they are refused. What is read lies in memory of
/// its own, so that the address sanitizer sees reads beyond it.
std::optional<Pixels> unpacked(std::string_view bytes, std::size_t count) {
  const std::vector<char> alone(bytes.begin(), bytes.end());
  Pixels pixels(count);
  try {
    const std::size_t size = unpack_sums({alone.data(), alone.size()}, pixels);
    CHECK(size <= bytes.size());
  } catch (const DecodeError&) {
    return {};
  }
  return pixels;
}

bool survives(const Pixels& pixels) { return unpacked(packed(pixels), pixels.size()) == pixels; }

/// Every number from `number(column)`, columns 0 .. 8.
Pixels made_of(std::size_t count, const std::function<std::uint64_t(std::size_t)>& number) {
  Pixels pixels(count);
  for (PixelSums& pixel : pixels) {
    for (std::size_t c = 0; c < 3; ++c) {
      pixel.sum[c] = number(c);
      pixel.sum_of_squares[c] = number(3 + c);
      pixel.odd[c] = number(6 + c);
    }
  }
  return pixels;
}

/// Radiance uniform in [0, 1], at the scale where 1 takes all 33 bits.
Pixels sampled(Dice& dice, std::size_t count, std::uint32_t samples, std::uint32_t first = 0) {
  const RadianceScale scale(1);
  Pixels pixels(count);
  for (PixelSums& pixel : pixels) {
    for (std::uint32_t s = first; s < first + samples; ++s) {
      pixel.add({scale.to_fixed(dice.unit()), scale.to_fixed(dice.unit()),
                 scale.to_fixed(dice.one_in(4) ? 1 : dice.unit())},
                s);
    }
  }
  return pixels;
}

std::uint64_t below_power(Dice& dice, std::size_t bits) {
  return bits == 0 ? 0 : dice.bits() >> (64 - bits);
}

/// Cells of all kinds, small enough to try every byte of.
std::vector<Pixels> samples_of_all_kinds(Dice& dice) {
  std::vector<Pixels> cells = {{}, Pixels(1), Pixels(5)};
  for (const std::uint32_t samples : {1U, 2U, 16U}) {
    cells.push_back(sampled(dice, 7, samples));
    cells.push_back(sampled(dice, 7, samples, 1));
  }
  cells.push_back(made_of(6, [&](auto) { return dice.bits(); }));
  cells.push_back(made_of(20, [&](auto column) { return (1ULL << 40) + dice.below(column + 1); }));
  cells.push_back(made_of(20, [](auto) { return 12345; }));
  return cells;
}

}  // namespace

TEST_CASE("packed sums come back, whatever the widths of their columns") {
  Dice dice(1);
  for (std::size_t bits = 0; bits <= 64; ++bits) {
    CAPTURE(bits);
    for (const std::size_t count : {1U, 2U, 9U, 100U}) {
      CHECK(survives(made_of(count, [&](auto) { return below_power(dice, bits); })));
    }
  }
  for (int trial = 0; trial < 500; ++trial) {
    std::array<std::size_t, 9> widths{};
    for (std::size_t& width : widths) width = dice.one_in(4) ? 64 - dice.below(9) : dice.below(65);
    std::array<std::uint64_t, 9> high{};
    for (std::size_t c = 0; c < 9 && dice.one_in(2); ++c) {
      high[c] = dice.bits() & ~(widths[c] == 64 ? most : (1ULL << widths[c]) - 1);
    }
    CHECK(survives(made_of(1 + dice.below(40), [&](auto column) {
      return high[column] | below_power(dice, widths[column]);
    })));
  }
}

TEST_CASE("the largest numbers, one pixel and no pixel are packed as well") {
  for (const std::size_t count : {0U, 1U, 2U, 2048U}) {
    CHECK(survives(made_of(count, [](auto) { return most; })));
    CHECK(survives(Pixels(count)));
  }
  Pixels apart(3);
  apart[1].sum_of_squares[1] = most;
  CHECK(survives(apart));
  CHECK(packed({}) == std::string("\3\0\0\0", 4));
}

TEST_CASE("a cell is the bytes that the format says") {
  PixelSums pixel;
  pixel.sum = {1, 2, 7};
  pixel.sum_of_squares = {0, 0, 1};
  pixel.odd = {1, 0, 0};
  // Bits, from the first: 1, 01, 111; 1; 1.
  CHECK(packed({pixel}) == std::string("\0\1\2\3\0\0\1\1\0\0\xfd", 11));
}

TEST_CASE("of samples that are alone only the sum is stored") {
  Dice dice(2);
  for (const std::uint32_t first : {0U, 1U}) {
    const Pixels pixels = sampled(dice, 2048, 1, first);
    CHECK(survives(pixels));
    CHECK(packed(pixels).size() <= 14 * pixels.size());
  }
  const Pixels pairs = sampled(dice, 2048, 2);
  CHECK(survives(pairs));
  CHECK(packed(pairs).size() <= 26 * pairs.size());
}

TEST_CASE("one pixel that breaks a rule makes its columns be stored") {
  Dice dice(3);
  Pixels pixels = sampled(dice, 100, 1, 1);
  ++pixels[99].sum_of_squares[2];
  CHECK(survives(pixels));
  --pixels[50].odd[0];
  CHECK(survives(pixels));
}

TEST_CASE("sixteen samples take little more than half of what they take unpacked") {
  Dice dice(4);
  const Pixels pixels = sampled(dice, 2048, 16);
  CHECK(survives(pixels));
  CHECK(packed(pixels).size() <= 42 * pixels.size());
}

TEST_CASE("a cell of equal pixels takes its header alone") {
  Dice dice(5);
  const Pixels pixels(1000, sampled(dice, 1, 16).front());
  CHECK(survives(pixels));
  CHECK(packed(pixels).size() == 1 + 9 * 9);
}

TEST_CASE("equal sums have equal bytes, wherever they are appended") {
  Dice dice(6);
  for (const Pixels& pixels : samples_of_all_kinds(dice)) {
    const Pixels same(pixels);
    std::string bytes = "before";
    pack_sums(same, bytes);
    CHECK(bytes == "before" + packed(pixels));
  }
}

TEST_CASE("bytes after packed sums are left alone") {
  Dice dice(7);
  for (const Pixels& pixels : samples_of_all_kinds(dice)) {
    const std::string bytes = packed(pixels);
    Pixels back(pixels.size());
    CHECK(unpack_sums(bytes + std::string(dice.below(100), '\xff'), back) == bytes.size());
    CHECK(back == pixels);
  }
}

TEST_CASE("packed sums that end early are refused at every byte") {
  Dice dice(8);
  for (const Pixels& pixels : samples_of_all_kinds(dice)) {
    const std::string bytes = packed(pixels);
    for (std::size_t size = 0; size < bytes.size(); ++size) {
      CHECK(!unpacked(std::string_view(bytes).substr(0, size), pixels.size()));
    }
  }
}

TEST_CASE("damaged bytes are refused, or they are what other sums are packed as") {
  Dice dice(9);
  std::size_t accepted = 0;
  for (const Pixels& pixels : samples_of_all_kinds(dice)) {
    const std::string bytes = packed(pixels);
    for (int trial = 0; trial < 2000; ++trial) {
      std::string damaged = bytes;
      for (std::uint64_t i = 1 + dice.below(3); i > 0; --i) {
        const std::size_t reach =
            dice.one_in(2) ? bytes.size() : std::min<std::size_t>(12, bytes.size());
        damaged[dice.below(reach)] =
            static_cast<char>(dice.one_in(2) ? dice.below(66) : dice.bits());
      }
      if (const auto other = unpacked(damaged, pixels.size())) {
        ++accepted;
        CHECK(damaged.starts_with(packed(*other)));
      }
    }
  }
  CHECK(accepted > 100);
}

TEST_CASE("noise is refused, or it is what some sums are packed as") {
  Dice dice(10);
  for (int trial = 0; trial < 20000; ++trial) {
    std::string bytes(dice.below(200), '\0');
    for (char& byte : bytes) byte = static_cast<char>(dice.one_in(3) ? dice.bits() : dice.below(5));
    if (const auto some = unpacked(bytes, dice.below(20))) CHECK(bytes.starts_with(packed(*some)));
  }
}

}  // namespace parray
