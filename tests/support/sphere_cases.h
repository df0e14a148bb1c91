#pragma once

#include <algorithm>
#include <cmath>

#include "tests/support/dice.h"
#include "tests/support/rooms.h"
#include "tests/support/sphere_oracle.h"

/// Single rays and spheres, and the errors of the tracer's answers.
namespace parray::test {

template <typename Real>
struct SphereCase {
  SphereShape<Real> sphere;
  Ray<Real> ray;
};

/// Makes a ray that starts `distance` radii from the centre, in a random direction from it, and
/// passes the centre at `impact` radii. One in 16 rays points away instead. |direction| = `speed`.
template <typename Real>
SphereCase<Real> aimed_case(Dice& dice, const SphereShape<Real>& sphere, double impact,
                            double distance, double speed) {
  const auto r = static_cast<double>(sphere.radius);
  const Vec3<Real> origin =
      vec_cast<Real>(vec_cast<double>(sphere.center) + (distance * r) * dice.direction());
  const Vec3d to_center = vec_cast<double>(sphere.center) - vec_cast<double>(origin);
  const Vec3d axis = normalize(to_center);
  const double sine = std::min(impact * r / length(to_center), 1.0);
  const Vec3d aim = std::sqrt(1 - sine * sine) * axis + sine * dice.across(axis);
  const double sign = dice.one_in(16) ? -1 : 1;
  return {sphere, {origin, vec_cast<Real>((sign * speed) * aim)}};
}

/// Makes a sphere with a radius from 10^-decades to 10^decades and its centre up to a million radii
/// from 0.
template <typename Real>
SphereShape<Real> any_sphere(Dice& dice, double decades) {
  const double r = dice.ten_to(-decades, decades);
  const double offset = dice.one_in(4) ? 0 : std::min(dice.ten_to(-3, 6) * r, 1e15);
  return {vec_cast<Real>(offset * dice.direction()), static_cast<Real>(r)};
}

/// Makes a sphere and a ray, with a log-uniform distance in [nearest, farthest] radii.
template <typename Real>
SphereCase<Real> sphere_case(Dice& dice, double decades, double impact, double nearest,
                             double farthest) {
  const SphereShape<Real> sphere = any_sphere<Real>(dice, decades);
  const double most =
      std::min(farthest, std::max(nearest, 1e15 / static_cast<double>(sphere.radius)));
  const double distance = nearest * std::pow(most / nearest, dice.unit());
  return aimed_case(dice, sphere, impact, distance, dice.ten_to(-6, 6));
}

/// Worst errors of enters() and normal_at(), in ulp(S).
struct WorstEntry {
  double backward = 0;
  double forward = 0;
  double normal = 0;
  double unit = 0;
  double band = 0;   ///< largest distance from tangency of a line with a wrong answer
  double speck = 0;  ///< the same for spheres with a radius below 4 ulp(S)
  int hits = 0;
  int misses = 0;

  template <typename Real>
  void look_at(const SphereCase<Real>& c) {
    const Exact<Real> truth(c.ray, c.sphere);
    if (truth.distance <= truth.radius) {
      return;  // rounding of the inputs has put the origin inside
    }
    Real t = 0;
    const bool hit = enters(c.ray, c.sphere, t);
    ++(hit ? hits : misses);
    if (hit != truth.enters()) {
      double& worst = truth.ulp <= Quad(0.25) ? band : speck;
      worst = std::max(worst, truth.tangency());
    }
    if (hit) backward = std::max(backward, truth.backward_error(t));
    if (hit && truth.enters()) {
      const Quad root = truth.foot - truth.half_chord;
      const Vec3<Real> n = normal_at(c.ray, c.sphere, false);
      forward = std::max(forward, truth.forward_error(t, root));
      normal = std::max(normal, truth.normal_error(n, root));
      unit = std::max(unit, unit_error(n));
    }
  }
};

}  // namespace parray::test
