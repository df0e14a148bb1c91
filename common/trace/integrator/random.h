#pragma once

#include <cstdint>

#include "common/math/philox.h"
#include "common/math/sobol.h"
#include "common/scene/setting_choices.h"

namespace parray::trace {

/// The use of a block of random numbers. It is part of a number's address: the values must not
/// change.
enum class Purpose : std::uint32_t {
  camera = 0,   ///< film x, film y, lens u, lens v
  scatter = 1,  ///< direction u, direction v (diffuse, fuzz) or choice (dielectric)
  fuzz = 2,     ///< radius of the fuzz ball: three numbers
};

/// Four uniform numbers in [0, 1) with 24 bits each. The values are the same in every precision, so
/// that precisions can be compared path by path.
template <typename Real>
struct Uniform4 {
  Real a, b, c, d;
};

/// The pairs of numbers that Sampler::sobol spreads evenly: those of the camera and of the first
/// scatterings. Each pair has its own order of points. Later bounces gained nothing from even
/// spreading.
///
/// A random search found the orders, one set after the other. It minimised the variance (the mean
/// of its logarithm over 4, 8 .. 2048 points) of integrands that depend on all numbers of the sets
/// so far together. Such an integrand is the mean over the points of the product of 1 + w
/// f(number). f is the cost of a jump in that number, by Walsh coefficients that halve with each
/// digit. w is 0.5 for the film and the first scattering, 0.2 for the second, 0.1 for the others.
struct SobolSets {
  static constexpr std::uint32_t bounces = 3;
  static constexpr PointOrder film{0, 0, 0, 0};
  static constexpr PointOrder lens{0xA8B62E, 0xD29FB5, 0x20B893, 0x117364};
  /// Returns the order for `bounce` < bounces. A table would have to be shared by the objects of
  /// all instruction sets.
  static constexpr PARRAY_INLINE PointOrder scatter(std::uint32_t bounce) {
    return bounce == 0   ? PointOrder{0xC4504B, 0x9B7F34, 0x15FC1F, 0xF9C071}
           : bounce == 1 ? PointOrder{0xD59E3C, 0xE6C489, 0x27054E, 0x7F3479}
                         : PointOrder{0xCECBB2, 0x13E347, 0xF711E7, 0xA09E6C};
  }
};

/// The random numbers of one sample, or of lanes of samples, addressed by (seed, pixel, sample,
/// bounce, purpose). The object holds only the address; no number depends on an earlier draw.
///
/// Sampler::independent: every number is independent of all others.
///
/// Sampler::sobol: the even and the odd samples of a pixel form two replicates. They are
/// independent of each other and of other pixels. Within a replicate, the numbers of the camera and
/// of the first scatterings are evenly spread, for any number of samples from the first on. All
/// other numbers are independent. Each single number is uniform.
template <typename Uint>
class RandomAddress {
 public:
  PARRAY_INLINE RandomAddress(std::uint64_t seed, Uint pixel, Uint sample,
                              Sampler sampler = Sampler::independent)
      : key_{static_cast<std::uint32_t>(seed), static_cast<std::uint32_t>(seed >> 32)},
        pixel_(pixel),
        sample_(sample),
        sampler_(sampler) {}

  /// Returns the numbers for `bounce` < 2^24, the number of surfaces that the path met before, and
  /// a purpose. Purpose::scatter has only a and b, Purpose::fuzz only a, b and c.
  template <typename Real>
  [[nodiscard]] PARRAY_INLINE Uniform4<Real> at(std::uint32_t bounce, Purpose purpose) const {
    if (sampler_ == Sampler::sobol) {
      if (purpose == Purpose::camera) {
        const auto film = pair<Real>(SobolSets::film, bounce, purpose, 1);
        const auto lens = pair<Real>(SobolSets::lens, bounce, purpose, 2);
        return {film.a, film.b, lens.a, lens.b};
      }
      if (purpose == Purpose::scatter && bounce < SobolSets::bounces) {
        const auto turn = pair<Real>(SobolSets::scatter(bounce), bounce, purpose, 1);
        return {turn.a, turn.b, Real(0), Real(0)};
      }
    }
    const PhiloxBlock<Uint> bits = block(sample_, bounce, purpose, 0);
    return {unit<Real>(bits.a >> 8), unit<Real>(bits.b >> 8), unit<Real>(bits.c >> 8),
            unit<Real>(bits.d >> 8)};
  }

 private:
  template <typename Real>
  struct Pair {
    Real a, b;
  };

  /// Returns a block of random bits. `use` separates the numbers themselves (0) from the keys of
  /// sets (1 and 2).
  PARRAY_INLINE PhiloxBlock<Uint> block(const Uint& sample, std::uint32_t bounce, Purpose purpose,
                                        std::uint32_t use) const {
    return philox4x32<Uint>(
        {pixel_, sample, Uint(bounce << 8 | static_cast<std::uint32_t>(purpose)), Uint(use)}, key_);
  }

  /// Returns two numbers of this sample's point in its replicate.
  template <typename Real>
  PARRAY_INLINE Pair<Real> pair(const PointOrder& order, std::uint32_t bounce, Purpose purpose,
                                std::uint32_t use) const {
    const Uint replicate = sample_ & Uint(1U);
    const PhiloxBlock<Uint> keys = block(replicate, bounce, purpose, use);
    const Uint point = order.of(sample_ >> 1);
    return {unit<Real>(number_of(scramble(point, keys.a, keys.b))),
            unit<Real>(number_of(scramble(sobol_second(point), keys.c, keys.d)))};
  }

  /// Converts an integer below 2^24 to [0, 1).
  template <typename Real>
  static PARRAY_INLINE Real unit(const Uint& bits) {
    return real_from<Real>(bits) * Real(0x1p-24);
  }

  PhiloxKey key_;
  Uint pixel_;
  Uint sample_;
  Sampler sampler_;
};

using SampleRandom = RandomAddress<std::uint32_t>;

}  // namespace parray::trace
