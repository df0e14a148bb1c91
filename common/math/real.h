#pragma once

#include <cmath>

namespace parray {

/// What the templates ask of a real type beyond + - * / and comparison. Another type (a wider one
/// as a test oracle) joins by specialising this.
template <typename Real>
struct RealTraits;

template <>
struct RealTraits<float> {
  static constexpr float unit_roundoff = 0x1p-24F;
  static constexpr int sine_terms = 5;  ///< Taylor terms that leave less than half an ulp
  static float sqrt(float x) { return std::sqrt(x); }  // one correctly rounded instruction
};

template <>
struct RealTraits<double> {
  static constexpr double unit_roundoff = 0x1p-53;
  static constexpr int sine_terms = 9;
  static double sqrt(double x) { return std::sqrt(x); }
};

/// Correctly rounded square root; `x` >= 0.
template <typename Real>
Real square_root(Real x) {
  return RealTraits<Real>::sqrt(x);
}

/// The comparisons of min and max, spelled out because NaN's place in them matters: a NaN in the
/// first argument yields the second.
template <typename Real>
constexpr Real min_of(Real a, Real b) {
  return a < b ? a : b;
}
template <typename Real>
constexpr Real max_of(Real a, Real b) {
  return a > b ? a : b;
}

}  // namespace parray
