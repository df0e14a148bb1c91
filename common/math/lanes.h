#pragma once

#include <cstdint>

#include "common/math/inline.h"
#include "common/math/real.h"

/// Lanes: several numbers in one vector. The arithmetic of a path is written once, as templates on
/// a type that behaves like a real number: float, double, a wider type as an oracle, or lanes.
/// Lanes hold `count` numbers and give for each exactly the bits of the scalar operation. Each
/// instruction set has a header of lanes: lanes_scalar.h, which describes the members and
/// functions, lanes_avx2.h, lanes_avx512.h and lanes_neon.h.
///
/// A comparison of lanes returns a mask. `select(mask, a, b)` returns a where the mask is set,
/// otherwise b. For scalars a mask is bool.
namespace parray::math {

/// The result type of a comparison.
template <typename Real>
using MaskOf = decltype(Real{} < Real{});

PARRAY_INLINE bool any(bool mask) { return mask; }

template <typename Real>
// Types with components choose component by component: see vec.h.
requires(!requires(Real real) { real.x; }) PARRAY_INLINE Real
    select(bool mask, const Real& a, const Real& b) {
  return mask ? a : b;
}

/// Returns `first`, `first` + 1 ...
template <typename Uint>
PARRAY_INLINE Uint counting_from(std::uint32_t first) {
  alignas(64) static constexpr std::uint32_t numbers[16] = {0, 1, 2,  3,  4,  5,  6,  7,
                                                            8, 9, 10, 11, 12, 13, 14, 15};
  return Uint::load(numbers) + Uint(first);
}

/// The high and low halves of products a b, which have twice the bits of a and b.
template <typename Uint>
struct WideProduct {
  Uint high;
  Uint low;
};
PARRAY_INLINE WideProduct<std::uint32_t> multiply_wide(std::uint32_t a, std::uint32_t b) {
  const std::uint64_t product = std::uint64_t{a} * b;
  return {static_cast<std::uint32_t>(product >> 32), static_cast<std::uint32_t>(product)};
}
/// Converts an integer below 2^24, or lanes of them, to reals.
template <typename Real, typename Uint>
PARRAY_INLINE Real real_from(const Uint& integer) {
  if constexpr (requires { Real::from(integer); }) {
    return Real::from(integer);
  } else {
    return static_cast<Real>(integer);
  }
}

/// Operators of lanes that one instruction computes from the registers `v`, for lanes_avx2.h and
/// lanes_avx512.h. `Count`: the type that the instruction has for a number of bits.
#define PARRAY_LANES_OPERATOR(T, op, instruction) \
  friend PARRAY_INLINE T operator op(T a, T b) { return T(instruction(a.v, b.v)); }
#define PARRAY_LANES_SHIFT(T, op, instruction, Count)      \
  friend PARRAY_INLINE T operator op(T a, int count) {     \
    return T(instruction(a.v, static_cast<Count>(count))); \
  }
#define PARRAY_LANES_COMPARISON(T, op, instruction, how) \
  friend PARRAY_INLINE Mask operator op(T a, T b) { return {instruction(a.v, b.v, how)}; }
#define PARRAY_LANES_COMPARISONS(T, instruction)          \
  PARRAY_LANES_COMPARISON(T, <, instruction, _CMP_LT_OQ)  \
  PARRAY_LANES_COMPARISON(T, <=, instruction, _CMP_LE_OQ) \
  PARRAY_LANES_COMPARISON(T, >, instruction, _CMP_GT_OQ)  \
  PARRAY_LANES_COMPARISON(T, >=, instruction, _CMP_GE_OQ) \
  PARRAY_LANES_COMPARISON(T, ==, instruction, _CMP_EQ_OQ)

}  // namespace parray::math
