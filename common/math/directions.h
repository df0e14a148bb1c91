#pragma once

#include <array>
#include <cstddef>

#include "common/math/real.h"
#include "common/math/vec.h"

/// Maps from uniform numbers in [0, 1) to shapes, in + - * / sqrt only: no libm, so that every
/// machine draws the same points.
namespace parray {

/// 1/n for the small n of the Taylor series, rounded once at compile time: a multiplication costs a
/// fifth of a division.
template <typename Real>
inline constexpr auto reciprocals = [] {
  std::array<Real, 400> table{};
  for (int n = 1; n < 400; ++n) {
    table[static_cast<std::size_t>(n)] = Real(1) / static_cast<Real>(n);
  }
  return table;
}();

template <typename Real>
struct CosSin {
  Real cos;
  Real sin;
};

/// Cosine and sine of 2 pi u for u in [0, 1): Taylor polynomials on [-pi/4, pi/4] around the
/// nearest quarter turn, in Horner form. Error: below 2 ulp of 1.
template <typename Real>
CosSin<Real> turn(Real u) {
  const Real quarters = Real(4) * u;
  const int quadrant = static_cast<int>(quarters + Real(0.5));  // 0 .. 4
  constexpr Real half_pi = Real(1.570796326794896619231321691639751442L);
  const Real x = (quarters - static_cast<Real>(quadrant)) * half_pi;
  const Real xx = x * x;
  Real sine = Real(1);
  Real cosine = Real(1);
  for (std::size_t k = RealTraits<Real>::sine_terms; k >= 1; --k) {
    sine = Real(1) - sine * (xx * reciprocals<Real>[2 * k * (2 * k + 1)]);
    cosine = Real(1) - cosine * (xx * reciprocals<Real>[(2 * k - 1) * 2 * k]);
  }
  sine = sine * x;
  switch (quadrant & 3) {
    case 1:
      return {-sine, cosine};
    case 2:
      return {-cosine, -sine};
    case 3:
      return {sine, -cosine};
    default:
      return {cosine, sine};
  }
}

/// Uniform point of the unit sphere's surface (Archimedes: z is uniform). u, v in [0, 1).
template <typename Real>
Vec3<Real> uniform_direction(Real u, Real v) {
  const Real z = Real(1) - Real(2) * u;
  const Real rho = Real(2) * square_root(u * (Real(1) - u));
  const CosSin<Real> phi = turn(v);
  return {rho * phi.cos, rho * phi.sin, z};
}

/// Uniform point of the unit ball: the largest of three uniform numbers is distributed as the
/// radius is (its distribution function is r^3), which spares a cube root.
template <typename Real>
Vec3<Real> uniform_ball(Real u, Real v, Real r1, Real r2, Real r3) {
  return max_of(r1, max_of(r2, r3)) * uniform_direction(u, v);
}

template <typename Real>
struct Disc {
  Real x;
  Real y;
};

/// Uniform point of the unit disc. u, v in [0, 1).
template <typename Real>
Disc<Real> uniform_disc(Real u, Real v) {
  const Real radius = square_root(u);
  const CosSin<Real> phi = turn(v);
  return {radius * phi.cos, radius * phi.sin};
}

}  // namespace parray
