#pragma once

#include "common/math/inline.h"
#include "common/math/lanes.h"
#include "common/math/real.h"

namespace parray::math {

/// Three components of a real type: a point, a direction or a linear RGB colour.
///
/// Every operation uses only + - * / and sqrt, each correctly rounded by IEEE 754. So a value
/// depends on its inputs alone, not on compilers or instruction sets.
template <typename Real>
struct Vec3 {
  Real x{};
  Real y{};
  Real z{};

  friend PARRAY_INLINE constexpr Vec3 operator+(const Vec3& a, const Vec3& b) {
    return {a.x + b.x, a.y + b.y, a.z + b.z};
  }
  friend PARRAY_INLINE constexpr Vec3 operator-(const Vec3& a, const Vec3& b) {
    return {a.x - b.x, a.y - b.y, a.z - b.z};
  }
  friend PARRAY_INLINE constexpr Vec3 operator-(const Vec3& a) { return {-a.x, -a.y, -a.z}; }
  friend PARRAY_INLINE constexpr Vec3 operator*(const Vec3& a, const Vec3& b) {
    return {a.x * b.x, a.y * b.y, a.z * b.z};
  }
  friend PARRAY_INLINE constexpr Vec3 operator*(Real s, const Vec3& a) {
    return {s * a.x, s * a.y, s * a.z};
  }
  friend bool operator==(const Vec3&, const Vec3&) = default;  // constexpr where Real's is
};

using Vec3d = Vec3<double>;

template <typename Real>
PARRAY_INLINE constexpr Real dot(const Vec3<Real>& a, const Vec3<Real>& b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}

template <typename Real>
PARRAY_INLINE constexpr Vec3<Real> cross(const Vec3<Real>& a, const Vec3<Real>& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

template <typename Real>
PARRAY_INLINE Real length(const Vec3<Real>& a) {
  return square_root(dot(a, a));
}

/// Returns the unit vector along `a`. `a` must not be zero, and its square must be within the range
/// of Real.
template <typename Real>
PARRAY_INLINE Vec3<Real> normalize(const Vec3<Real>& a) {
  return (Real(1) / length(a)) * a;
}

/// Chooses component by component: see lanes.h.
template <typename Mask, typename Real>
PARRAY_INLINE Vec3<Real> select(Mask mask, const Vec3<Real>& a, const Vec3<Real>& b) {
  return {select(mask, a.x, b.x), select(mask, a.y, b.y), select(mask, a.z, b.z)};
}

/// Converts each component, rounded to nearest.
template <typename To, typename From>
PARRAY_INLINE constexpr Vec3<To> vec_cast(const Vec3<From>& a) {
  return {static_cast<To>(a.x), static_cast<To>(a.y), static_cast<To>(a.z)};
}

/// Returns the point nearest to `p` in the segment from -half to +half; 0 for a segment so short
/// that its square underflows.
template <typename Real>
PARRAY_INLINE Vec3<Real> nearest_in_segment(const Vec3<Real>& half, const Vec3<Real>& p) {
  const Real square = dot(half, half);
  const Real along = square > Real(0) ? dot(p, half) / square : Real(0);
  return min_of(max_of(along, Real(-1)), Real(1)) * half;
}

}  // namespace parray::math
