#include "common/math/lanes.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <stdexcept>
#include <string_view>
#include <type_traits>

#include "tests/support/dice.h"
#include "tests/support/lane_operations.h"
#include "tests/support/lane_search.h"
#include "tests/support/rooms.h"

/// Lanes of every instruction set against the scalar operations of this file, which is compiled for
/// none.
namespace parray::test {
namespace {

template <typename T>
using BitsOf = std::conditional_t<sizeof(T) == sizeof(float), std::uint32_t, std::uint64_t>;

/// Any bits, or what arithmetic finds hard.
template <typename T>
T hard(Dice& dice) {
  using Limits = std::numeric_limits<T>;
  const std::array<T, 12> special{T(0),
                                  T(1),
                                  T(1.5),
                                  T(16777216),
                                  Limits::infinity(),
                                  Limits::quiet_NaN(),
                                  Limits::signaling_NaN(),
                                  Limits::denorm_min(),
                                  Limits::min() - Limits::denorm_min(),
                                  Limits::min(),
                                  Limits::max(),
                                  Limits::epsilon()};
  switch (dice.below(4)) {
    case 0: return std::copysign(special[dice.below(special.size())], static_cast<T>(dice.sign()));
    case 1: return static_cast<T>(dice.sign() * dice.ten_to(-3, 3));
    case 2: return static_cast<T>(dice.below(5)) - 2;  // often equal
    default: return std::bit_cast<T>(static_cast<BitsOf<T>>(dice.bits()));
  }
}

std::uint32_t any_uint(Dice& dice) {
  const auto bits = static_cast<std::uint32_t>(dice.bits());
  return dice.one_in(3) ? bits & static_cast<std::uint32_t>(dice.bits() & dice.bits()) : bits;
}

template <typename T>
LaneInputs<T> inputs(Dice& dice, std::uint32_t lanes) {
  LaneInputs<T> in{};
  for (int i = 0; i < most_lanes; ++i) {
    in.a[i] = hard<T>(dice);
    in.b[i] = dice.one_in(8) ? in.a[i] : hard<T>(dice);
    const T other = hard<T>(dice);
    in.ordered[i] = std::isnan(other) ? std::numeric_limits<T>::infinity() : other;
    in.narrower[i] = hard<float>(dice);
    // Half way between two floats, or anything.
    in.wider[i] =
        dice.one_in(4) ? 1.0 + static_cast<double>(dice.below(64)) * 0x1p-24 : hard<double>(dice);
    in.p[i] = any_uint(dice);
    in.q[i] = dice.one_in(4) ? in.p[i] : any_uint(dice);
    in.index[i] = dice.below32(64);
    in.place[i] = dice.below32(most_lanes);
    in.small[i] = dice.below32(1U << 24);
    in.shift[i] = dice.one_in(2) ? dice.below32(64) : any_uint(dice);
    in.order[i] = static_cast<std::uint8_t>(dice.below(lanes));
  }
  for (T& entry : in.table) entry = hard<T>(dice);
  in.set = static_cast<std::uint32_t>(dice.bits()) & ((1U << lanes) - 1);
  return in;
}

template <typename T, typename Output>
void compress(const T* from, std::uint32_t set, Output& to) {
  int next = 0;
  for (int i = 0; i < most_lanes; ++i) {
    if ((set >> i & 1) != 0) to[next++] = from[i];
  }
}

template <typename T>
bool agree(T found, T expected, Free free) {
  if (free == Free::nan && std::isnan(expected)) return std::isnan(found);
  return free == Free::zero ? found == expected
                            : std::bit_cast<BitsOf<T>>(found) == std::bit_cast<BitsOf<T>>(expected);
}

/// a b + c, rounded once or twice: as `found` is, if that is one of them.
template <typename T>
T multiplied_and_added(T found, T a, T b, T c) {
  const T rounded_twice = a * b + c;
  return agree(found, rounded_twice, Free::nan) ? rounded_twice : std::fma(a, b, c);
}

template <typename T>
void expect_reals(const LaneInputs<T>& in, const LaneResults<T>& found, int lanes,
                  LaneResults<T>& out) {
  constexpr int multiply_add = 4;
  T least = in.ordered[0];
  for (int i = 0; i < lanes; ++i) {
    const T a = in.a[i];
    const T b = in.b[i];
    const T convert =
        sizeof(T) == sizeof(float) ? static_cast<T>(in.wider[i]) : static_cast<T>(in.narrower[i]);
    const std::array<T, real_rows - 3> values{
        a + b,
        a - b,
        a * b,
        a / b,
        multiplied_and_added(found.real[multiply_add][i], a, b, in.table[i]),
        std::sqrt(a),
        convert,
        static_cast<T>(in.narrower[in.place[i]]),
        -a,
        a,
        in.a[0],
        a < b ? a : b,
        (in.set >> i & 1) != 0 ? a : b,
        a < b ? a : b,
        a > b ? a : b,
        in.table[in.index[i]],
        static_cast<T>(in.small[i]),
        in.a[in.order[i]]};
    for (std::size_t row = 0; row < values.size(); ++row) out.real[row][i] = values[row];
    least = in.ordered[i] < least ? in.ordered[i] : least;
  }
  compress(in.a, in.set, out.real[real_rows - 3]);
  std::fill_n(out.real[real_rows - 2], lanes, least);
  out.real[real_rows - 1][0] = in.a[0];
}

template <typename T>
void expect_masks(const LaneInputs<T>& in, int lanes, LaneResults<T>& out) {
  for (std::uint32_t& mask : out.mask) mask = 0;
  for (int i = 0; i < lanes; ++i) {
    const T a = in.a[i];
    const T b = in.b[i];
    const std::array<bool, mask_rows - 2> values{
        a<b, a <= b, a> b, a >= b, a == b, a == b, a < b || a > b, in.p[i] == in.q[i]};
    for (std::size_t row = 0; row < values.size(); ++row) {
      out.mask[row] |= static_cast<std::uint32_t>(values[row]) << i;
    }
  }
  out.mask[mask_rows - 1] = out.mask[0] != 0 ? 1 : 0;
}

template <typename T>
void expect_uints(const LaneInputs<T>& in, int lanes, LaneResults<T>& out) {
  for (int i = 0; i < lanes; ++i) {
    const std::uint32_t p = in.p[i];
    const std::uint32_t q = in.q[i];
    const std::uint64_t product = std::uint64_t{p} * q;
    const auto block = philox4x32<std::uint32_t>({p, q, q, p}, {in.set, 77});
    const std::array<std::uint32_t, uint_rows> values{p,
                                                      in.p[0],
                                                      p + q,
                                                      p * q,
                                                      p ^ q,
                                                      p & q,
                                                      p >> 1,
                                                      p >> 8,
                                                      p >> 31,
                                                      p << 1,
                                                      p << 8,
                                                      p << 31,
                                                      static_cast<std::uint32_t>(product >> 32),
                                                      static_cast<std::uint32_t>(product),
                                                      in.a[i] < in.b[i] ? p : q,
                                                      (in.set >> i & 1) != 0 ? p : q,
                                                      in.q[in.place[i]],
                                                      in.p[in.order[i]],
                                                      0,
                                                      block.a,
                                                      block.b,
                                                      block.c,
                                                      block.d,
                                                      in.shift[i] < 32 ? 1U << in.shift[i] : 0U};
    for (std::size_t row = 0; row < values.size(); ++row) out.uint[row][i] = values[row];
  }
  constexpr int compressed = 18;
  compress(in.p, in.set, out.uint[compressed]);
}

/// Counts of wrong answers, by operation.
struct Wrong {
  std::array<int, real_rows> real{};
  std::array<int, mask_rows> mask{};
  std::array<int, uint_rows> uint{};
};

/// Lanes of a row that say something.
int lanes_of(const Operation& operation, int lanes, std::uint32_t set) {
  const std::string_view name = operation.name;
  return name == "first_of" ? 1 : name == "compress_store" ? std::popcount(set) : lanes;
}

template <typename T>
void compare(const LaneResults<T>& found, const LaneResults<T>& expected, int lanes,
             std::uint32_t set, Wrong& wrong) {
  for (std::size_t row = 0; row < real_rows; ++row) {
    for (int i = 0; i < lanes_of(real_operations[row], lanes, set); ++i) {
      const bool good = agree(found.real[row][i], expected.real[row][i], real_operations[row].free);
      wrong.real[row] += good ? 0 : 1;
    }
    for (int i = lanes; i < most_lanes; ++i) {  // nothing is written beyond the lanes
      wrong.real[row] += found.real[row][i] == T(0) ? 0 : 1;
    }
  }
  for (std::size_t row = 0; row < mask_rows; ++row) {
    wrong.mask[row] += found.mask[row] == expected.mask[row] ? 0 : 1;
  }
  for (std::size_t row = 0; row < uint_rows; ++row) {
    for (int i = 0; i < lanes_of(uint_operations[row], lanes, set); ++i) {
      wrong.uint[row] += found.uint[row][i] == expected.uint[row][i] ? 0 : 1;
    }
    for (int i = lanes; i < most_lanes; ++i) wrong.uint[row] += found.uint[row][i] == 0 ? 0 : 1;
  }
}

template <typename T>
struct LanesOfIsa {
  void (*operate)(const LaneInputs<T>&, LaneResults<T>&);
  int count;
};

template <typename T>
LanesOfIsa<T> lanes_of_isa(Isa isa) {
  constexpr bool single = sizeof(T) == sizeof(float);
  switch (isa) {
#define PARRAY_LANES_OF(isa) \
  case Isa::isa:             \
    return {test::isa::operate, single ? trace::isa::float_width : trace::isa::double_width};
    PARRAY_FOR_EACH_ISA(PARRAY_LANES_OF)
#undef PARRAY_LANES_OF
    default: throw std::logic_error("this build has no lanes for the instruction set");
  }
}

}  // namespace

TEST_CASE_TEMPLATE("every operation of lanes does to each lane what the scalar does", T, float,
                   double) {
  for (const Isa isa : instruction_sets()) {
    CAPTURE(name_of(isa));
    const LanesOfIsa<T> lanes = lanes_of_isa<T>(isa);
    Dice dice(21);
    Wrong wrong;
    for (int round = 0; round < 20'000; ++round) {
      const auto in = inputs<T>(dice, static_cast<std::uint32_t>(lanes.count));
      LaneResults<T> found{};
      LaneResults<T> expected{};
      lanes.operate(in, found);
      expect_reals(in, found, lanes.count, expected);
      expect_masks(in, lanes.count, expected);
      expect_uints(in, lanes.count, expected);
      compare(found, expected, lanes.count, in.set, wrong);
    }
    for (std::size_t row = 0; row < real_rows; ++row) {
      CAPTURE(std::string_view(real_operations[row].name));
      CHECK(wrong.real[row] == 0);
    }
    for (std::size_t row = 0; row < mask_rows; ++row) {
      CAPTURE(std::string_view(mask_operations[row].name));
      CHECK(wrong.mask[row] == 0);
    }
    for (std::size_t row = 0; row < uint_rows; ++row) {
      CAPTURE(std::string_view(uint_operations[row].name));
      CHECK(wrong.uint[row] == 0);
    }
  }
}

}  // namespace parray::test
