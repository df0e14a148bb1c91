#pragma once

#include <bit>
#include <cstdint>

#include "common/rooms.h"

namespace parray::image {

/// Fixed point for radiance: a value x becomes the integer nearest to x * 2^bits, at most 2^32.
///
/// Integer sums are associative, so any split of samples over workers, merged in any order, gives
/// the same bits. 2^31 samples fit a 64-bit sum. Immutable; any thread.
class RadianceScale {
 public:
  /// `largest` is the largest radiance that a sample can have: finite, >= 0. The scale is the
  /// power of two that maps it into (2^31, 2^32]; 0, or less than any float32 can show, counts
  /// as 1.
  explicit RadianceScale(double largest) {
    double unit = 1;
    if (!(largest >= 0x1p-200)) {
      largest = 1;
    }
    while (unit < largest) {
      unit *= 2;
    }
    while (unit * 0.5 >= largest) {
      unit *= 0.5;
    }
    to_fixed_ = one / unit;
    from_fixed_ = unit / one;
  }

  /// `value` is finite. Clamped to [0, 2^32]: rounding may exceed the bound by an ulp.
  [[nodiscard]] std::uint64_t to_fixed(double value) const {
    const double scaled = value * to_fixed_;
    const double positive = scaled > 0 ? scaled : 0;
    const double bounded = positive < one ? positive : one;
    return fixed_of(bounded + shift);
  }

  /// Adding this rounds a number in [0, 2^32] to the nearest integer, ties to even, and leaves it
  /// in the low bits: see fixed_of(). Lanes of any instruction set can do that.
  static constexpr double shift = 0x1p52;
  /// The integer in a sum of it and `shift`.
  static std::uint64_t fixed_of(double shifted) {
    return std::bit_cast<std::uint64_t>(shifted) - std::bit_cast<std::uint64_t>(shift);
  }
  /// What a value is multiplied by.
  [[nodiscard]] double factor() const { return to_fixed_; }
  /// The largest fixed-point value.
  static constexpr double one = 0x1p32;

  /// Mean of `count` > 0 samples whose fixed-point values add up to `sum`.
  [[nodiscard]] double mean(std::uint64_t sum, std::uint64_t count) const {
    return static_cast<double>(sum) / static_cast<double>(count) * from_fixed_;
  }

  /// Mean of squares from `sum`, a sum of square_of() values.
  [[nodiscard]] double mean_square(std::uint64_t sum, std::uint64_t count) const {
    return static_cast<double>(sum) / static_cast<double>(count) * from_fixed_ * from_fixed_ * one;
  }

  /// The square of a fixed-point value, 32 bits shifted out so that sums fit 64 bits.
  static std::uint64_t square_of(std::uint64_t fixed) {
    __extension__ using Wide = unsigned __int128;  // 2^32 squared needs it
    return static_cast<std::uint64_t>(Wide{fixed} * fixed >> 32);
  }

 private:
  double to_fixed_;
  double from_fixed_;
};

}  // namespace parray::image
