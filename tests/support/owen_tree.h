#pragma once

#include <array>
#include <cstdint>

#include "tests/support/dice.h"
#include "tests/support/rooms.h"

namespace parray::test {

/// Nested uniform scrambling as in the textbook. Each node of a binary tree has a random coin that
/// decides whether the next digit is flipped. The tree stores the coins of ten digits. Points that
/// differ in these digits visit each later node only once, so its coin is not stored. Source: Owen,
/// "Randomly permuted (t,m,s)-nets and (t,s)-sequences", 1995.
class OwenTree {
 public:
  explicit OwenTree(std::uint64_t seed) : dice_(seed) {
    for (std::uint64_t& coins : coins_) coins = dice_.bits();
  }

  /// Scrambles 24 binary digits, the first in bit 0. The first ten digits must differ in all calls.
  std::uint32_t scrambled(std::uint32_t digits) {
    std::uint32_t result = digits ^ (dice_.below32(1U << 24) & ~0U << depth);
    for (int digit = 0; digit < depth; ++digit) {
      const std::uint32_t node = (digits & ((1U << digit) - 1)) | 1U << digit;
      const bool flip = (coins_[node / 64] >> node % 64 & 1) != 0;
      result ^= flip ? 1U << digit : 0U;
    }
    return result;
  }

 private:
  static constexpr int depth = 10;

  Dice dice_;
  std::array<std::uint64_t, (1U << depth) / 64> coins_{};
};

}  // namespace parray::test
