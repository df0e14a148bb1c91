#pragma once

#include <cstdint>

#include "common/math/lanes.h"

/// Points that fill the unit square evenly, and their randomisation. `Uint` is a 32-bit unsigned
/// integer or lanes of them.
///
/// A coordinate in [0, 1) is stored as its first 24 binary digits in reverse order: bit 0 counts
/// halves, bit 1 quarters. Products and sums carry from lower to higher bits. So each digit of a
/// result depends only on the same and earlier (larger) digits of the operands. Bits from 24 on
/// have no meaning.
namespace parray::math {

/// Returns the second coordinate of point `index`; the first one is `index` itself. Among the 2^k
/// points from any multiple of 2^k on, each elementary interval of area 2^-k contains one: a (0,
/// 2)-sequence in base 2. The generator matrix is Pascal's triangle modulo 2. `index` < 2^24.
/// Source: Sobol, "On the distribution of points in a cube and the approximate evaluation of
/// integrals", 1967.
template <typename Uint>
PARRAY_INLINE Uint sobol_second(Uint index) {
  index = index ^ (index >> 1 & Uint(0x55555555U));
  index = index ^ (index >> 2 & Uint(0x33333333U));
  index = index ^ (index >> 4 & Uint(0x0F0F0F0FU));
  index = index ^ (index >> 8 & Uint(0x00FF00FFU));
  return index ^ index >> 16;
}

/// A fixed permutation of the points. Every pair of coordinates uses the same points, but has its
/// own permutation (SobolSets in common/trace/integrator/random.h). So all pairs together are well
/// distributed. Bit j of the result is bit j of the index plus some of the bits above it, modulo 2.
/// The permutation maps the 2^k points from a multiple of 2^k on to such a set, and the first 2^k
/// points to themselves.
struct PointOrder {
  /// Bits to which the bit 1, 2, 4 or 8 places above is added.
  std::uint32_t by_1, by_2, by_4, by_8;

  template <typename Uint>
  [[nodiscard]] PARRAY_INLINE Uint of(Uint index) const {
    index = index ^ (index >> 1 & Uint(by_1));
    index = index ^ (index >> 2 & Uint(by_2));
    index = index ^ (index >> 4 & Uint(by_4));
    return index ^ (index >> 8 & Uint(by_8));
  }
};

/// Scrambles the digits of a coordinate at random, by two uniform integers that the points of a set
/// share. The last line multiplies by an odd number and adds `shift`. For each pair of points, this
/// has exactly the effect of nested uniform scrambling (Owen 1995). If two coordinates differ first
/// in digit i, the results are uniform, share the digits before it, differ in it, and are
/// independent after it. So the mean of any integrand over a set has the same variance as with
/// nested uniform scrambling. The first two lines apply another bijection in which no digit depends
/// on later ones, so all this still holds. The last line alone is a linear map. Its regularity
/// would show in the fourth moment of the means over larger sets. The bijection removes it.
template <typename Uint>
PARRAY_INLINE Uint scramble(Uint digits, const Uint& factor, const Uint& shift) {
  digits = digits + (factor >> 24);  // bits that the product does not use
  digits = digits ^ digits * Uint(0x3D20ADEAU);
  return digits * (factor << 1 ^ Uint(1U)) + shift;
}

/// Returns the coordinate times 2^24, an integer.
template <typename Uint>
PARRAY_INLINE Uint number_of(Uint digits) {
  digits = (digits >> 1 & Uint(0x55555555U)) ^ (digits & Uint(0x55555555U)) << 1;
  digits = (digits >> 2 & Uint(0x33333333U)) ^ (digits & Uint(0x33333333U)) << 2;
  digits = (digits >> 4 & Uint(0x0F0F0F0FU)) ^ (digits & Uint(0x0F0F0F0FU)) << 4;
  return (digits << 16 & Uint(0xFF0000U)) ^ (digits & Uint(0xFF00U)) ^ (digits >> 16 & Uint(0xFFU));
}

}  // namespace parray::math
