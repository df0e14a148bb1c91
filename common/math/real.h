#pragma once

#include <limits>

#include "common/math/inline.h"
#include "common/rooms.h"

namespace parray::math {

/// The properties of a real type that the templates need beyond + - * / and comparison. A
/// specialisation adds another type, such as a wider one as a test oracle.
template <typename Real>
struct RealTraits;

template <>
struct RealTraits<float> {
  static constexpr float unit_roundoff = 0x1p-24F;
  static constexpr float infinity = std::numeric_limits<float>::infinity();
  static constexpr int sine_terms = 5;  ///< Taylor terms with an error below half an ulp
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

/// Returns the correctly rounded square root; `x` >= 0.
template <typename Real>
PARRAY_INLINE Real square_root(Real x) {
  return RealTraits<Real>::sqrt(x);
}

/// Return the minimum and the maximum. The comparisons are spelled out, because the place of a NaN
/// matters: if either argument is NaN, the result is the second argument.
template <typename Real>
PARRAY_INLINE constexpr Real min_of(Real a, Real b) {
  return a < b ? a : b;
}
template <typename Real>
PARRAY_INLINE constexpr Real max_of(Real a, Real b) {
  return a > b ? a : b;
}

}  // namespace parray::math
