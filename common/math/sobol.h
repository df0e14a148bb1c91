#pragma once

#include <cstdint>

#include "common/math/lanes.h"

/// Points that fill the unit square evenly, and their randomisation. `Uint` is a 32-bit unsigned
/// integer or lanes of them.
///
/// A coordinate in [0, 1) is held as its binary digits in reverse: bit 0 is the half, bit 1 the
/// quarter. Then what happens to a digit depends on lower bits alone, which is how sums and
/// products carry.
namespace parray {

/// Digits of point `index` in the second dimension of the Sobol sequence; those in the first are
/// `index` itself. Of any 2^k points from a multiple of 2^k on, each elementary interval of area
/// 2^-k holds one. The generator matrix is Pascal's triangle modulo 2.
/// Source: Sobol, "On the distribution of points in a cube", 1967.
template <typename Uint>
PARRAY_INLINE Uint sobol_second(Uint index) {
  index = index ^ (index >> 1 & Uint(0x55555555U));
  index = index ^ (index >> 2 & Uint(0x33333333U));
  index = index ^ (index >> 4 & Uint(0x0F0F0F0FU));
  index = index ^ (index >> 8 & Uint(0x00FF00FFU));
  return index ^ index >> 16;
}

/// Another order of the points: bit j of the result is bit j of `index` plus some bits above it,
/// modulo 2, so that 2^k points from a multiple of 2^k on stay such.
struct IndexOrder {
  std::uint32_t by_1, by_2, by_4, by_8;

  template <typename Uint>
  [[nodiscard]] PARRAY_INLINE Uint of(Uint index) const {
    index = index ^ (index >> 1 & Uint(by_1));
    index = index ^ (index >> 2 & Uint(by_2));
    index = index ^ (index >> 4 & Uint(by_4));
    return index ^ (index >> 8 & Uint(by_8));
  }
};

/// Random scrambling of `digits` by a uniform odd `factor` and a uniform `shift`. Of two numbers
/// that first differ in digit i, the results, each uniform, share the digits above it, differ in
/// it, and are independent below: the law of nested uniform scrambling for each pair of points, and
/// hence its variance for any integrand. The fixed map in between keeps that law, and makes sets of
/// more points less regular.
/// Source of the law: Owen, "Randomly permuted (t,m,s)-nets and (t,s)-sequences", 1995.
template <typename Uint>
PARRAY_INLINE Uint scramble(Uint digits, Uint factor, Uint shift) {
  return digits * factor + shift;
}

/// From reversed digits to an integer of 24 bits: the number times 2^24.
template <typename Uint>
PARRAY_INLINE Uint number_of(Uint digits) {
  digits = (digits >> 1 & Uint(0x55555555U)) ^ (digits & Uint(0x55555555U)) << 1;
  digits = (digits >> 2 & Uint(0x33333333U)) ^ (digits & Uint(0x33333333U)) << 2;
  digits = (digits >> 4 & Uint(0x0F0F0F0FU)) ^ (digits & Uint(0x0F0F0F0FU)) << 4;
  return (digits << 16 & Uint(0xFF0000U)) ^ (digits & Uint(0xFF00U)) ^ (digits >> 16 & Uint(0xFFU));
}

}  // namespace parray
