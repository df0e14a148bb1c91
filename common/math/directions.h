#pragma once

#include <cstddef>

#include "common/math/real.h"
#include "common/math/vec.h"

/// Maps uniform numbers in [0, 1) to shapes with + - * / and sqrt only. It uses no libm, so that
/// every machine draws the same points.
namespace parray::math {

/// Returns 1/n for the small n of the Taylor series, rounded once at compile time: a multiplication
/// costs a fifth of a division.
template <typename Real>
PARRAY_INLINE Real reciprocal(std::size_t n) {
  using Scalar = decltype(RealTraits<Real>::unit_roundoff + 0);
  return Real(Scalar(1) / static_cast<Scalar>(n));
}

template <typename Real>
struct CosSin {
  Real cos;
  Real sin;
};

/// Returns cosine and sine of x in [-pi/4, pi/4]: Taylor polynomials in Horner form.
template <typename Real>
PARRAY_INLINE CosSin<Real> sincos_near_zero(Real x) {
  const Real xx = x * x;
  Real sine = Real(1);
  Real cosine = Real(1);
  for (std::size_t k = RealTraits<Real>::sine_terms; k >= 1; --k) {
    sine = Real(1) - sine * (xx * reciprocal<Real>(2 * k * (2 * k + 1)));
    cosine = Real(1) - cosine * (xx * reciprocal<Real>((2 * k - 1) * 2 * k));
  }
  return {cosine, sine * x};
}

/// Returns cosine and sine of 2 pi u for u in [0, 1), computed from the nearest quarter turn.
/// Absolute error: below 2 ulp of 1.
template <typename Real>
PARRAY_INLINE CosSin<Real> sincos_2pi(Real u) {
  const Real quarters = Real(4) * u;
  const auto first = quarters >= Real(0.5);
  const auto second = quarters >= Real(1.5);
  const auto third = quarters >= Real(2.5);
  const auto fourth = quarters >= Real(3.5);
  const Real nearest =
      select(fourth, Real(4),
             select(third, Real(3), select(second, Real(2), select(first, Real(1), Real(0)))));
  using Scalar = decltype(RealTraits<Real>::unit_roundoff + 0);
  const Real half_pi(static_cast<Scalar>(1.570796326794896619231321691639751442L));
  const auto [cosine, sine] = sincos_near_zero((quarters - nearest) * half_pi);
  return {select(fourth, cosine,
                 select(third, sine, select(second, -cosine, select(first, -sine, cosine)))),
          select(fourth, sine,
                 select(third, -cosine, select(second, -sine, select(first, cosine, sine))))};
}

/// Returns a uniform point of the unit sphere's surface (Archimedes: y is uniform). u, v in [0, 1).
/// y points to the top of the sky. The light of the sky depends on y alone, and y on u alone. So
/// evenly spread u sample this light evenly.
template <typename Real>
PARRAY_INLINE Vec3<Real> uniform_direction(Real u, Real v) {
  const Real y = Real(1) - Real(2) * u;
  const Real rho = Real(2) * square_root(u * (Real(1) - u));
  const CosSin<Real> phi = sincos_2pi(v);
  return {rho * phi.sin, y, rho * phi.cos};
}

/// Returns a uniform point of the unit ball; all arguments in [0, 1). The largest of three uniform
/// numbers has the distribution of the radius (distribution function r^3), which avoids a cube
/// root.
template <typename Real>
PARRAY_INLINE Vec3<Real> uniform_ball(Real u, Real v, Real r1, Real r2, Real r3) {
  return max_of(r1, max_of(r2, r3)) * uniform_direction(u, v);
}

template <typename Real>
struct Disc {
  Real x;
  Real y;
};

/// Returns a uniform point of the unit disc. u, v in [0, 1). Squares about the centre become
/// circles, so that evenly spread numbers give evenly spread points. Source: Shirley and Chiu, "A
/// low distortion map between disk and square", 1997.
template <typename Real>
PARRAY_INLINE Disc<Real> uniform_disc(Real u, Real v) {
  const Real a = Real(2) * u - Real(1);
  const Real b = Real(2) * v - Real(1);
  const auto steep = b * b > a * a;
  const Real radius = select(steep, b, a);
  const Real slope = select(steep, a, b) / select(radius == Real(0), Real(1), radius);
  using Scalar = decltype(RealTraits<Real>::unit_roundoff + 0);
  const Real eighth_turn(static_cast<Scalar>(0.785398163397448309615660845819875721L));
  const CosSin<Real> phi = sincos_near_zero(slope * eighth_turn);
  return {radius * select(steep, phi.sin, phi.cos), radius * select(steep, phi.cos, phi.sin)};
}

}  // namespace parray::math
