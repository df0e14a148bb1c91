#pragma once

#include <limits>

#include "common/math/inline.h"
#include "common/rooms.h"

namespace parray::math {

/// What the templates ask of a real type beyond + - * / and comparison. Another type (a wider one
/// as a test oracle) joins by specialising this.
template <typename Real>
struct RealTraits;

template <>
struct RealTraits<float> {
  static constexpr float unit_roundoff = 0x1p-24F;
  static constexpr float infinity = std::numeric_limits<float>::infinity();
  static constexpr int sine_terms = 5;  ///< Taylor terms that leave less than half an ulp
  // One correctly rounded instruction.
  static PARRAY_INLINE float sqrt(float x) { return __builtin_sqrtf(x); }
};

template <>
struct RealTraits<double> {
  static constexpr double unit_roundoff = 0x1p-53;
  static constexpr double infinity = std::numeric_limits<double>::infinity();
  static constexpr int sine_terms = 9;
  static PARRAY_INLINE double sqrt(double x) { return __builtin_sqrt(x); }
};

/// Correctly rounded square root; `x` >= 0.
template <typename Real>
PARRAY_INLINE Real square_root(Real x) {
  return RealTraits<Real>::sqrt(x);
}

/// The comparisons of min and max, spelled out because NaN's place in them matters: a NaN in the
/// first argument yields the second.
template <typename Real>
PARRAY_INLINE constexpr Real min_of(Real a, Real b) {
  return a < b ? a : b;
}
template <typename Real>
PARRAY_INLINE constexpr Real max_of(Real a, Real b) {
  return a > b ? a : b;
}

}  // namespace parray::math
