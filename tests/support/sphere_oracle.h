#pragma once

#include "common/trace/sphere.h"
#include "tests/support/quad.h"
#include "tests/support/rooms.h"

namespace parray::test {

/// A ray and a sphere with exact answers for their stored numbers. The unit of all errors is a
/// radius times ulp(S), S = max(1, distance / radius).
template <typename Real>
struct Exact {
  Exact(const Ray<Real>& ray, const SphereShape<Real>& sphere)
      : radius(sphere.radius),
        direction(exact(ray.direction)),
        from_origin(exact(sphere.center) - exact(ray.origin)),
        square(dot(direction, direction)),
        foot(dot(from_origin, direction) / square),
        distance(quad_length(from_origin)) {
    const QuadVec perpendicular = from_origin - foot * direction;
    const Quad scale = distance > radius ? distance / radius : Quad(1);
    ulp = 2 * static_cast<Quad>(RealTraits<Real>::unit_roundoff) * scale;
    impact = quad_length(perpendicular) / radius;
    // Never zero, so that an error at the tangent is compared with a finite bound.
    steepness = quad_sqrt(impact < 1 ? 1 - impact * impact : Quad(0)) + ulp;
    half_chord = quad_sqrt((radius * radius - dot(perpendicular, perpendicular)) / square);
  }

  [[nodiscard]] bool enters() const { return distance > radius && foot > 0 && impact <= 1; }
  /// Returns the distance of the point at `t` from the surface.
  [[nodiscard]] double backward_error(Real t) const {
    const QuadVec point = static_cast<Quad>(t) * direction - from_origin;
    return static_cast<double>(quad_abs(quad_length(point) - radius) / radius / ulp);
  }
  /// Returns its distance from the exact crossing at `root`, times sqrt(1 - b^2).
  [[nodiscard]] double forward_error(Real t, Quad root) const {
    const Quad error = quad_abs(static_cast<Quad>(t) - root) * quad_sqrt(square) / radius;
    return static_cast<double>(error / ulp * steepness);
  }
  [[nodiscard]] double normal_error(const Vec3<Real>& normal, Quad root) const {
    const QuadVec true_normal = (1 / radius) * (root * direction - from_origin);
    return static_cast<double>(quad_length(exact(normal) - true_normal) / ulp * steepness);
  }
  /// Returns the distance of the line from tangency.
  [[nodiscard]] double tangency() const { return static_cast<double>(quad_abs(impact - 1) / ulp); }

  Quad radius;
  QuadVec direction;
  QuadVec from_origin;
  Quad square;
  Quad foot;
  Quad distance;
  Quad ulp;
  Quad impact;
  Quad steepness;
  Quad half_chord;
};

template <typename Real>
double unit_error(const Vec3<Real>& v) {
  const Quad ulp = 2 * static_cast<Quad>(RealTraits<Real>::unit_roundoff);
  return static_cast<double>(quad_abs(quad_length(exact(v)) - 1) / ulp);
}

}  // namespace parray::test
