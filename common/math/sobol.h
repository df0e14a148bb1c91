#pragma once

#include <cstdint>

#include "common/math/lanes.h"

/// Points that fill the unit square evenly, and their randomisation. `Uint` is a 32-bit unsigned
/// integer or lanes of them.
///
/// A coordinate in [0, 1) is held as its first 24 binary digits in reverse: bit 0 counts halves,
/// bit 1 quarters. So a digit's fate depends on lower bits alone, which is how products and sums
/// carry. Bits from 24 on mean nothing.
namespace parray::math {

/// The second coordinate of point `index`; the first is `index` itself. Of the 2^k points from any
/// multiple of 2^k on, each elementary interval of area 2^-k holds one: a (0, 2)-sequence in
/// base 2. The generator matrix is Pascal's triangle modulo 2. `index` < 2^24. Source: Sobol, "On
/// the distribution of points in a cube and the approximate evaluation of integrals", 1967.
template <typename Uint>
PARRAY_INLINE Uint sobol_second(Uint index) {
  index = index ^ (index >> 1 & Uint(0x55555555U));
  index = index ^ (index >> 2 & Uint(0x33333333U));
  index = index ^ (index >> 4 & Uint(0x0F0F0F0FU));
  index = index ^ (index >> 8 & Uint(0x00FF00FFU));
  return index ^ index >> 16;
}

/// A fixed permutation of the points, so that pairs of coordinates that take the same points in
/// orders of their own are well distributed jointly: bit j of the result is bit j of the index plus
/// some of the bits above it, modulo 2. The 2^k points from a multiple of 2^k on stay such, and the
/// first 2^k stay the first.
struct PointOrder {
  std::uint32_t by_1, by_2, by_4, by_8;  ///< which bits get that of so many places above added

  template <typename Uint>
  [[nodiscard]] PARRAY_INLINE Uint of(Uint index) const {
    index = index ^ (index >> 1 & Uint(by_1));
    index = index ^ (index >> 2 & Uint(by_2));
    index = index ^ (index >> 4 & Uint(by_4));
    return index ^ (index >> 8 & Uint(by_8));
  }
};

/// Scrambles the digits of a coordinate at random, by two uniform integers that the points of a set
/// share. The odd multiplier and the sum do, to each pair of points, what nested uniform scrambling
/// (Owen 1995) does, exactly: of two coordinates that differ first in digit i, the results are
/// uniform, share the digits before it, differ in it, and are independent after it. The mean of any
/// integrand over a set has the same variance, therefore. The map before it, another bijection in
/// which no digit depends on later ones, keeps that law; it takes from larger sets the regularity
/// of a linear map, which shows in the fourth moment.
template <typename Uint>
PARRAY_INLINE Uint scramble(Uint digits, const Uint& factor, const Uint& shift) {
  digits = digits + (factor >> 24);  // bits of no use to the product
  digits = digits ^ digits * Uint(0x3D20ADEAU);
  return digits * (factor << 1 ^ Uint(1U)) + shift;
}

/// The coordinate times 2^24, an integer.
template <typename Uint>
PARRAY_INLINE Uint number_of(Uint digits) {
  digits = (digits >> 1 & Uint(0x55555555U)) ^ (digits & Uint(0x55555555U)) << 1;
  digits = (digits >> 2 & Uint(0x33333333U)) ^ (digits & Uint(0x33333333U)) << 2;
  digits = (digits >> 4 & Uint(0x0F0F0F0FU)) ^ (digits & Uint(0x0F0F0F0FU)) << 4;
  return (digits << 16 & Uint(0xFF0000U)) ^ (digits & Uint(0xFF00U)) ^ (digits >> 16 & Uint(0xFFU));
}

}  // namespace parray::math
