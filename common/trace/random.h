#pragma once

#include <cstdint>

#include "common/math/philox.h"

namespace parray {

/// What a block of random numbers is for. Part of a number's address: values must not change.
enum class Purpose : std::uint32_t {
  camera = 0,   ///< film x, film y, lens u, lens v
  scatter = 1,  ///< direction u, direction v (diffuse, fuzz) or choice (dielectric)
  fuzz = 2,     ///< radius of the fuzz ball: three numbers
};

/// Four uniform numbers in [0, 1) with 24 bits each: the same values in every precision, so that
/// precisions can be compared path by path.
template <typename Real>
struct Uniform4 {
  Real a, b, c, d;
};

/// The random numbers of one sample, or of lanes of samples, addressed by (seed, pixel, sample,
/// bounce, purpose). Holds the address only; nothing is drawn in sequence.
template <typename Uint>
class RandomAddress {
 public:
  PARRAY_INLINE RandomAddress(std::uint64_t seed, Uint pixel, Uint sample)
      : key_{static_cast<std::uint32_t>(seed), static_cast<std::uint32_t>(seed >> 32)},
        pixel_(pixel),
        sample_(sample) {}

  /// `bounce` < 2^24.
  template <typename Real>
  [[nodiscard]] PARRAY_INLINE Uniform4<Real> at(std::uint32_t bounce, Purpose purpose) const {
    const PhiloxBlock<Uint> bits = philox4x32<Uint>(
        {pixel_, sample_, Uint(bounce << 8 | static_cast<std::uint32_t>(purpose)), Uint(0U)}, key_);
    return {unit<Real>(bits.a), unit<Real>(bits.b), unit<Real>(bits.c), unit<Real>(bits.d)};
  }

 private:
  template <typename Real>
  static PARRAY_INLINE Real unit(Uint bits) {
    return real_from<Real>(bits >> 8) * Real(0x1p-24);
  }

  PhiloxKey key_;
  Uint pixel_;
  Uint sample_;
};

using SampleRandom = RandomAddress<std::uint32_t>;

}  // namespace parray
