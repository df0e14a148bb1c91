#include "common/math/sobol.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

#include "common/trace/integrator/random.h"
#include "tests/support/dice.h"
#include "tests/support/rooms.h"
#include "tests/support/statistics.h"

namespace parray {
namespace {

using test::Dice;

constexpr std::array<PointOrder, 5> orders{SobolSets::film, SobolSets::lens, SobolSets::scatter(0),
                                           SobolSets::scatter(1), SobolSets::scatter(2)};

std::uint32_t bits32(Dice& dice) { return static_cast<std::uint32_t>(dice.bits() >> 32); }

/// The reversed digits of a point's two coordinates in one of the orders.
std::array<std::uint32_t, 2> digits_of(const PointOrder& order, std::uint32_t index) {
  const std::uint32_t point = order.of(index);
  return {point, sobol_second(point)};
}

/// Whether each of the elementary intervals of 2^-x by 2^-y holds one of the points.
bool one_in_each(const std::vector<std::uint32_t>& a, const std::vector<std::uint32_t>& b, int x,
                 int y) {
  std::vector<bool> met(a.size());
  for (std::size_t i = 0; i < a.size(); ++i) {
    const std::size_t cell = (a[i] & ((1U << x) - 1)) | (b[i] & ((1U << y) - 1)) << x;
    if (met[cell]) return false;
    met[cell] = true;
  }
  return true;
}

bool is_net(const std::vector<std::uint32_t>& a, const std::vector<std::uint32_t>& b, int k) {
  for (int x = 0; x <= k; ++x) {
    if (!one_in_each(a, b, x, k - x)) return false;
  }
  return true;
}

/// A coordinate of the points [first, first + 2^k) of a set; `part` is 0 or 1.
std::vector<std::uint32_t> coordinate(const PointOrder& order, std::size_t part,
                                      std::uint32_t first, int k) {
  std::vector<std::uint32_t> result;
  for (std::uint32_t i = 0; i < 1U << k; ++i) result.push_back(digits_of(order, first + i)[part]);
  return result;
}

/// The least t such that 2^t of the first 2^k points lie in each elementary interval of area
/// 2^(t-k): 0 is best, k says nothing.
int quality(const std::vector<std::uint32_t>& a, const std::vector<std::uint32_t>& b, int k) {
  for (int t = 0; t < k; ++t) {
    bool even = true;
    for (int x = 0; x <= k - t && even; ++x) {
      const int y = k - t - x;
      std::vector<std::uint32_t> count(std::size_t{1} << (k - t));
      for (std::size_t i = 0; i < a.size(); ++i) {
        ++count[(a[i] & ((1U << x) - 1)) | (b[i] & ((1U << y) - 1)) << x];
      }
      for (const std::uint32_t n : count) even = even && n == 1U << t;
    }
    if (even) return t;
  }
  return k;
}

}  // namespace

TEST_CASE("the second coordinate comes from Pascal's triangle") {
  for (std::uint32_t column = 0; column < 24; ++column) {
    std::uint32_t expected = 0;  // Lucas: binomial (n, k) is odd where k's bits are among n's
    for (std::uint32_t row = 0; row <= column; ++row) {
      expected |= (column & row) == row ? 1U << row : 0U;
    }
    CHECK(sobol_second(1U << column) == expected);
  }
}

TEST_CASE("every aligned run of 2^k points of every set fills the square evenly") {
  for (const PointOrder& order : orders) {
    for (int k = 0; k <= 10; ++k) {
      for (const std::uint32_t run : {0U, 1U, 5U, 1000U}) {
        const std::uint32_t first = run << k;
        CHECK(is_net(coordinate(order, 0, first, k), coordinate(order, 1, first, k), k));
      }
    }
  }
}

TEST_CASE("an order moves no point out of the first 2^k") {
  for (const PointOrder& order : orders) {
    for (int k = 0; k <= 12; ++k) {
      std::vector<bool> met(std::size_t{1} << k);
      for (std::uint32_t i = 0; i < 1U << k; ++i) {
        REQUIRE(order.of(i) < 1U << k);
        met[order.of(i)] = true;
      }
      CHECK(std::count(met.begin(), met.end(), true) == 1 << k);
    }
  }
}

TEST_CASE("coordinates of different sets are evenly distributed jointly") {
  // Measured once; a sequence that shares an order between two sets has k - 1 or k.
  constexpr std::array<int, 11> worst{0, 1, 2, 2, 3, 3, 4, 4, 5, 4, 5};
  for (int k = 3; k <= 10; ++k) {
    int most = 0;
    for (std::size_t i = 0; i < orders.size(); ++i) {
      for (std::size_t j = 0; j < i; ++j) {
        for (const std::size_t p : {0U, 1U}) {
          for (const std::size_t q : {0U, 1U}) {
            const int t =
                quality(coordinate(orders[i], p, 0, k), coordinate(orders[j], q, 0, k), k);
            most = std::max(most, t);
          }
        }
      }
    }
    CHECK(most <= worst[static_cast<std::size_t>(k)]);
  }
}

TEST_CASE("scrambling permutes the intervals of every size") {
  Dice dice(3);
  for (int trial = 0; trial < 100; ++trial) {
    const std::uint32_t factor = bits32(dice);
    const std::uint32_t shift = bits32(dice);
    for (int k = 0; k <= 10; ++k) {
      std::vector<bool> met(std::size_t{1} << k);
      for (std::uint32_t i = 0; i < 1U << k; ++i) {
        // What comes after the first k digits does not matter to them.
        const std::uint32_t mask = (1U << k) - 1;
        const std::uint32_t to = scramble(i, factor, shift) & mask;
        REQUIRE(to == (scramble(i | bits32(dice) << k, factor, shift) & mask));
        REQUIRE_FALSE(met[to]);
        met[to] = true;
      }
    }
  }
}

TEST_CASE("scrambled pairs are distributed as by nested uniform scrambling") {
  // Two numbers that first differ in digit i: what becomes of digit j of their difference.
  Dice dice(4);
  constexpr int trials = 20'000;
  for (const int i : {0, 1, 3, 7}) {
    std::array<double, 24> differ{};
    std::vector<double> joint(64);
    for (int trial = 0; trial < trials; ++trial) {
      const std::uint32_t factor = bits32(dice);
      const std::uint32_t shift = bits32(dice);
      const std::uint32_t a = scramble(0x00ABCDU, factor, shift);
      const std::uint32_t b = scramble(0x00ABCDU ^ (0x00F1U << i & ~0U << i), factor, shift);
      for (int j = 0; j < 24; ++j) differ[static_cast<std::size_t>(j)] += (a ^ b) >> j & 1;
      joint[(a >> (i + 1) & 7) | ((b >> (i + 1) & 7) << 3)] += 1;
    }
    for (int j = 0; j < i; ++j) CHECK(differ[static_cast<std::size_t>(j)] == 0);
    CHECK(differ[static_cast<std::size_t>(i)] == trials);
    for (int j = i + 1; j < 24; ++j) {
      CHECK(std::abs(test::z_score(differ[static_cast<std::size_t>(j)], trials, 0.5, 0.25)) <
            test::z_limit);
    }
    CHECK(std::abs(test::chi_square_z(joint)) < test::z_limit);
  }
}

TEST_CASE("numbers are the digits read forwards") {
  CHECK(number_of(0U) == 0);
  CHECK(number_of(1U) == 1U << 23);
  CHECK(number_of(1U << 23) == 1);
  CHECK(number_of(0xFF000000U) == 0);  // bits that mean nothing
  CHECK(number_of(0x00123456U) == 0x6A2C48U);
}

TEST_CASE("scrambling has known answers") {
  CHECK(scramble(0U, 0U, 0U) == 0);
  CHECK((scramble(0x5A5A5AU, 0x12345678U, 0x9ABCDEF0U) & 0xFFFFFFU) == 0xB08E84U);
  CHECK((scramble(1U, 0xFFFFFFFFU, 7U) & 0xFFFFFFU) == 0x521507U);
}

}  // namespace parray
