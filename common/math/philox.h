#pragma once

#include <cstdint>

#include "common/math/lanes.h"

namespace parray::math {

/// 128 bits: a Philox counter or its random block. `Uint` is a 32-bit unsigned integer or lanes of
/// them.
template <typename Uint>
struct PhiloxBlock {
  Uint a, b, c, d;
};

struct PhiloxKey {
  std::uint32_t low, high;
};

/// Computes Philox4x32 with 10 rounds: 128 random bits for each (counter, key), without state.
/// Source: Salmon, Moraes, Dror, Shaw, "Parallel random numbers: as easy as 1, 2, 3", SC 2011.
template <typename Uint>
PARRAY_INLINE PhiloxBlock<Uint> philox4x32(PhiloxBlock<Uint> counter, PhiloxKey key) {
  constexpr std::uint32_t weyl_0 = 0x9E3779B9;  // golden ratio
  constexpr std::uint32_t weyl_1 = 0xBB67AE85;  // sqrt(3) - 1
  const Uint multiplier_0(0xD2511F53U);
  const Uint multiplier_1(0xCD9E8D57U);
#pragma GCC unroll 10
  for (int round = 0; round < 10; ++round) {
    const WideProduct<Uint> product_0 = multiply_wide(multiplier_0, counter.a);
    const WideProduct<Uint> product_1 = multiply_wide(multiplier_1, counter.c);
    counter = {product_1.high ^ counter.b ^ Uint(key.low), product_1.low,
               product_0.high ^ counter.d ^ Uint(key.high), product_0.low};
    key.low += weyl_0;
    key.high += weyl_1;
  }
  return counter;
}

}  // namespace parray::math
