#pragma once

#include <bit>
#include <cstdint>

#include "common/rooms.h"

namespace parray::image {

/// The fixed-point form of radiance: a value x becomes the integer nearest to x * factor(), at most
/// 2^32.
///
/// Integer sums are associative. So any split of samples over workers, merged in any order, gives
/// the same bits. A 64-bit sum holds 2^31 samples. Immutable and thread-safe.
class RadianceScale {
 public:
  /// `largest` is the largest possible radiance of a sample: finite, >= 0. factor() is the power of
  /// two that maps it into (2^31, 2^32]. 0, and values below 2^-200, count as 1.
  explicit RadianceScale(double largest) {
    double unit = 1;
    if (!(largest >= 0x1p-200)) largest = 1;
    while (unit < largest) unit *= 2;
    while (unit * 0.5 >= largest) unit *= 0.5;
    to_fixed_ = one / unit;
    from_fixed_ = unit / one;
  }

  /// Converts a finite value. The result is clamped to [0, 2^32], because rounding may exceed the
  /// bound by an ulp.
  [[nodiscard]] std::uint64_t to_fixed(double value) const {
    const double scaled = value * to_fixed_;
    const double positive = scaled > 0 ? scaled : 0;
    const double bounded = positive < one ? positive : one;
    return fixed_of(bounded + shift);
  }

  /// Adding this constant rounds a number in [0, 2^32] to the nearest integer, ties to even, and
  /// leaves the integer in the low bits: see fixed_of(). Lanes of every instruction set can do
  /// that.
  static constexpr double shift = 0x1p52;
  /// Returns the integer in the sum of a number and `shift`.
  static std::uint64_t fixed_of(double shifted) {
    return std::bit_cast<std::uint64_t>(shifted) - std::bit_cast<std::uint64_t>(shift);
  }
  /// Returns the factor from radiance to fixed point.
  [[nodiscard]] double factor() const { return to_fixed_; }
  /// The largest fixed-point value.
  static constexpr double one = 0x1p32;

  /// Returns the mean radiance of `count` > 0 samples from `sum`, the sum of their fixed-point
  /// values.
  [[nodiscard]] double mean(std::uint64_t sum, std::uint64_t count) const {
    return static_cast<double>(sum) / static_cast<double>(count) * from_fixed_;
  }

  /// Returns the mean squared radiance of `count` > 0 samples from `sum`, the sum of their
  /// square_of() values.
  [[nodiscard]] double mean_square(std::uint64_t sum, std::uint64_t count) const {
    return static_cast<double>(sum) / static_cast<double>(count) * from_fixed_ * from_fixed_ * one;
  }

  /// Returns the square of a fixed-point value, shifted right by 32 bits so that sums fit 64 bits.
  static std::uint64_t square_of(std::uint64_t fixed) {
#if defined(__SIZEOF_INT128__) && !defined(__SPIRV__)
    __extension__ using Wide = unsigned __int128;  // 2^32 squared needs it
    return static_cast<std::uint64_t>(Wide{fixed} * fixed >> 32);
#else
    const std::uint64_t low = fixed & 0xFFFFFFFF;
    const std::uint64_t high = fixed >> 32;
    return (high * high << 32) + 2 * high * low + (low * low >> 32);
#endif
  }

 private:
  double to_fixed_;
  double from_fixed_;
};

}  // namespace parray::image
