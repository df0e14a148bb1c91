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

/// The random numbers of one sample, addressed by (seed, pixel, sample, bounce, purpose). Holds
/// the address only; nothing is drawn in sequence.
class SampleRandom {
 public:
  SampleRandom(std::uint64_t seed, std::uint32_t pixel, std::uint32_t sample)
      : key_{static_cast<std::uint32_t>(seed), static_cast<std::uint32_t>(seed >> 32)},
        pixel_(pixel),
        sample_(sample) {}

  /// `bounce` < 2^24.
  template <typename Real>
  [[nodiscard]] Uniform4<Real> at(std::uint32_t bounce, Purpose purpose) const {
    const PhiloxCounter bits =
        philox4x32({pixel_, sample_, bounce << 8 | static_cast<std::uint32_t>(purpose), 0}, key_);
    return {unit<Real>(bits[0]), unit<Real>(bits[1]), unit<Real>(bits[2]), unit<Real>(bits[3])};
  }

 private:
  template <typename Real>
  static Real unit(std::uint32_t bits) {
    return static_cast<Real>(bits >> 8) * Real(0x1p-24);
  }

  PhiloxKey key_;
  std::uint32_t pixel_;
  std::uint32_t sample_;
};

}  // namespace parray
