#pragma once

#include <cstdint>

#include "common/math/philox.h"
#include "common/math/sobol.h"
#include "common/scene/settings.h"

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
  PARRAY_INLINE RandomAddress(std::uint64_t seed, Uint pixel, Uint sample,
                              Sampler sampler = Sampler::independent)
      : key_{static_cast<std::uint32_t>(seed), static_cast<std::uint32_t>(seed >> 32)},
        pixel_(pixel),
        sample_(sample),
        sampler_(sampler) {}

  /// `bounce` < 2^24.
  template <typename Real>
  [[nodiscard]] PARRAY_INLINE Uniform4<Real> at(std::uint32_t bounce, Purpose purpose) const {
    if (sampler_ == Sampler::sobol && purpose != Purpose::fuzz) {
      return spread<Real>(bounce, purpose);
    }
    const PhiloxBlock<Uint> bits = block(sample_, bounce, purpose, 0);
    return {unit<Real>(bits.a >> 8), unit<Real>(bits.b >> 8), unit<Real>(bits.c >> 8),
            unit<Real>(bits.d >> 8)};
  }

 private:
  PARRAY_INLINE PhiloxBlock<Uint> block(Uint sample, std::uint32_t bounce, Purpose purpose,
                                        std::uint32_t use) const {
    return philox4x32<Uint>(
        {pixel_, sample, Uint(bounce << 8 | static_cast<std::uint32_t>(purpose)), Uint(use)}, key_);
  }

  template <typename Real>
  PARRAY_INLINE Uniform4<Real> spread(std::uint32_t bounce, Purpose purpose) const {
    const Uint replicate = sample_ & Uint(1U);
    const Uint index = sample_ >> 1;
    const PhiloxBlock<Uint> keys = block(replicate, bounce, purpose, 1);
    const Uint order = IndexOrder{0, 0, 0, 0}.of(index);
    const Real a =
        unit<Real>(number_of(scramble(order, keys.a ^ (keys.a & Uint(1U)) ^ Uint(1U), keys.b)));
    const Real b = unit<Real>(
        number_of(scramble(sobol_second(order), keys.c ^ (keys.c & Uint(1U)) ^ Uint(1U), keys.d)));
    return {a, b, a, b};
  }

  template <typename Real>
  static PARRAY_INLINE Real unit(Uint bits) {
    return real_from<Real>(bits) * Real(0x1p-24);
  }

  PhiloxKey key_;
  Uint pixel_;
  Uint sample_;
  Sampler sampler_;
};

using SampleRandom = RandomAddress<std::uint32_t>;

}  // namespace parray
