#pragma once

#include <bit>
#include <cstdint>

#include "common/math/real.h"
#include "common/rooms.h"

/// Single operations of arithmetic with random operands. The same code is a kernel of a device and
/// a function of the host. So only results travel between them.
namespace parray::bench {

template <typename Real>
struct ProbeBits;
template <>
struct ProbeBits<float> {
  using Word = std::uint32_t;
  static constexpr int mantissa = 23;
};
template <>
struct ProbeBits<double> {
  using Word = std::uint64_t;
  static constexpr int mantissa = 52;
};

/// Bits of a number by parts.
template <typename Real>
struct ProbeNumber {
  using Word = typename ProbeBits<Real>::Word;
  static constexpr int mantissa = ProbeBits<Real>::mantissa;
  static constexpr Word exponent_mask = (~Word(0) << 1 >> 1) & (~Word(0) << mantissa);
  static constexpr Word one = exponent_mask >> 1 & exponent_mask;  ///< the bits of 1

  /// Returns `word` with the exponent `exponent` (0: denormal, or zero).
  static Word with_exponent(Word word, Word exponent) {
    return (word & ~exponent_mask) | (exponent << mantissa & exponent_mask);
  }
  /// Returns zero, infinity, NaN, or a number at the edge of a range.
  static Word special(std::uint32_t which) {
    const Word sign = Word(which & 1) << (sizeof(Word) * 8 - 1);
    switch (which >> 1 & 7) {
      case 0: return sign;
      case 1: return sign | exponent_mask;
      case 2: return sign | exponent_mask | 1;
      case 3: return sign | 1;
      case 4: return sign | ((Word(1) << mantissa) - 1);
      case 5: return sign | Word(1) << mantissa;
      case 6: return sign | (exponent_mask - 1);
      default: return sign | one;
    }
  }
};

/// Returns 64 random bits, a function of `x` (the finaliser of splitmix64).
inline std::uint64_t probe_mix(std::uint64_t x) {
  x = (x ^ x >> 30) * 0xBF58476D1CE4E5B9ULL;
  x = (x ^ x >> 27) * 0x94D049BB133111EBULL;
  return x ^ x >> 31;
}

/// Operands of one operation.
template <typename Real>
struct ProbeOperands {
  Real a, b, c;
};

/// Changes random operands by a random choice: see probe_operands().
template <typename Word, typename Number>
void choose_operands(std::uint64_t choice, Word& a, Word& b) {
  constexpr Word middle = Number::one >> Number::mantissa;
  const auto small = static_cast<Word>(choice >> 8 & 7);
  const auto other = static_cast<Word>(choice >> 11 & 15);
  switch (choice & 7) {
    case 4:
    case 5:
      a = Number::with_exponent(a, middle + small);
      b = Number::with_exponent(b, middle + small % 3);
      break;
    case 6:
      a = Number::with_exponent(a, other);
      b = Number::with_exponent(b, middle + small - 4);
      break;
    case 7:
      (choice >> 15 & 1 ? a : b) = Number::special(static_cast<std::uint32_t>(choice >> 16));
      break;
    default: break;
  }
}

/// Returns operands number `index`. Half of them have random bits. The exponents of a quarter are
/// close together, so that all bits of the result count. An eighth is denormal or nearly so, and an
/// eighth contains a special number. Three quarters of `c` nearly or exactly cancel the product.
template <typename Real>
ProbeOperands<Real> probe_operands(std::uint64_t index) {
  using Number = ProbeNumber<Real>;
  using Word = typename Number::Word;
  constexpr std::uint64_t step = 0x9E3779B97F4A7C15ULL;
  const std::uint64_t choice = probe_mix((4 * index + 1) * step);
  auto a = static_cast<Word>(probe_mix((4 * index + 2) * step));
  auto b = static_cast<Word>(probe_mix((4 * index + 3) * step));
  auto c = static_cast<Word>(probe_mix((4 * index + 4) * step));
  choose_operands<Word, Number>(choice, a, b);
  const Real first = std::bit_cast<Real>(a);
  const Real second = std::bit_cast<Real>(b);
  const std::uint64_t near_product = choice >> 20 & 3;
  if (near_product != 0) {
    const Word noise = near_product == 1 ? 0 : static_cast<Word>(choice >> 32 & 0xFFFF);
    c = std::bit_cast<Word>(-(first * second)) ^ noise;
  }
  return {first, second, std::bit_cast<Real>(c)};
}

/// Operations.
struct ProbeAdd {
  template <typename Real>
  static Real of(const ProbeOperands<Real>& x) {
    return x.a + x.b;
  }
};
struct ProbeSubtract {
  template <typename Real>
  static Real of(const ProbeOperands<Real>& x) {
    return x.a - x.b;
  }
};
struct ProbeMultiply {
  template <typename Real>
  static Real of(const ProbeOperands<Real>& x) {
    return x.a * x.b;
  }
};
struct ProbeDivide {
  template <typename Real>
  static Real of(const ProbeOperands<Real>& x) {
    return x.a / x.b;
  }
};
/// A quarter of the roots are of negative numbers.
struct ProbeRoot {
  template <typename Real>
  static Real of(const ProbeOperands<Real>& x) {
    return math::square_root(x.a > 0 || x.b < 0 ? x.a : -x.a);
  }
};
/// Product and sum, each rounded: a fused operation differs.
struct ProbeContract {
  template <typename Real>
  static Real of(const ProbeOperands<Real>& x) {
    return x.a * x.b + x.c;
  }
};

/// P(name of the kernel, Real, operation).
#define PARRAY_FOR_EACH_DEVICE_PROBE(P)       \
  P(probe_f32_div, float, ProbeDivide)        \
  P(probe_f32_sqrt, float, ProbeRoot)         \
  P(probe_f64_div, double, ProbeDivide)       \
  P(probe_f64_sqrt, double, ProbeRoot)        \
  P(probe_f32_add, float, ProbeAdd)           \
  P(probe_f32_sub, float, ProbeSubtract)      \
  P(probe_f32_mul, float, ProbeMultiply)      \
  P(probe_f32_contract, float, ProbeContract) \
  P(probe_f64_add, double, ProbeAdd)          \
  P(probe_f64_sub, double, ProbeSubtract)     \
  P(probe_f64_mul, double, ProbeMultiply)     \
  P(probe_f64_contract, double, ProbeContract)

/// Returns the result of operation number `index`: the body of a kernel.
template <typename Real, typename Operation>
Real probe(std::uint64_t index) {
  return Operation::template of<Real>(probe_operands<Real>(index));
}

}  // namespace parray::bench
