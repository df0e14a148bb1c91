#pragma once

#include "common/trace/ray.h"

namespace parray::trace {

template <typename Real>
struct SphereShape {
  Vec3<Real> center;
  Real radius;
};

/// Converts the type of a shape's numbers.
template <typename To, typename From>
PARRAY_INLINE SphereShape<To> shape_cast(const SphereShape<From>& sphere) {
  return {vec_cast<To>(sphere.center), static_cast<To>(sphere.radius)};
}

/// A point on the surface of a shape.
template <typename Real>
struct SurfacePoint {
  Vec3<Real> normal;  ///< outward, of unit length
  Vec3<Real> center;  ///< the sphere's centre, or the nearest point of the capsule's segment
  Real radius;

  [[nodiscard]] PARRAY_INLINE Vec3<Real> position() const { return center + radius * normal; }
};

/// Returns whether a point lies inside a sphere.
template <typename Real>
PARRAY_INLINE MaskOf<Real> contains(const SphereShape<Real>& sphere, const Vec3<Real>& point) {
  const Vec3<Real> from_center = point - sphere.center;
  return dot(from_center, from_center) < sphere.radius * sphere.radius;
}

/// Returns half the chord in units of the ray parameter, from values of a ClosestApproach and a
/// Ray.
template <typename Real>
PARRAY_INLINE Real half_chord(const Real& depth_squared, const Real& inverse_square) {
  return square_root(max_of(depth_squared, Real(0)) * inverse_square);
}

/// The point where a line is closest to a sphere's centre: the foot of the perpendicular from the
/// centre, and its depth inside the surface. Subtracting before squaring keeps the error at a few
/// ulp of max(radius, distance) for every impact parameter. The decision between hit and miss is
/// wrong only within 2 such ulp of tangency [measured], or within 3 if the radius is less than 4 of
/// them. Source: Haines, Guenther, Akenine-Moeller, "Precision improvements for ray/sphere
/// intersection", Ray Tracing Gems, 2019, chapter 7.
template <typename Real>
struct ClosestApproach {
  Real foot;                 ///< ray parameter of the foot
  Vec3<Real> perpendicular;  ///< from the foot to the centre
  Real depth_squared;        ///< radius^2 - |perpendicular|^2; < 0: the line misses

  PARRAY_INLINE ClosestApproach(const Ray<Real>& ray, const SphereShape<Real>& sphere) {
    const Vec3<Real> to_center = sphere.center - ray.origin;
    foot = dot(to_center, ray.direction) * ray.inverse_square;
    perpendicular = to_center - foot * ray.direction;
    depth_squared = sphere.radius * sphere.radius - dot(perpendicular, perpendicular);
  }

  /// Returns whether a ray that starts outside enters the sphere.
  [[nodiscard]] PARRAY_INLINE MaskOf<Real> approaches() const {
    return (foot > Real(0)) & (depth_squared >= Real(0));
  }

  /// Returns half the chord in units of the ray parameter; 0 if the line misses.
  [[nodiscard]] PARRAY_INLINE Real half_chord(const Ray<Real>& ray) const {
    return trace::half_chord(depth_squared, ray.inverse_square);
  }
};

/// Returns the ray parameter, >= 0, at which a ray that approaches a sphere enters it, from the
/// values of a ClosestApproach.
template <typename Real>
PARRAY_INLINE Real entry_distance(const Real& foot, const Real& depth_squared,
                                  const Real& inverse_square) {
  return max_of(foot - half_chord(depth_squared, inverse_square), Real(0));
}

/// Finds the point where a ray from outside enters a sphere. Returns whether it enters; if so, sets
/// `t` >= 0. With lanes of rays, the result and `t` are by lane. `t` is undefined in a lane that
/// does not enter.
///
/// The path knows that it is outside, so the far crossing is never needed. On an approaching ray,
/// rounding may place a crossing behind the origin (surfaces that touch); its `t` becomes 0. No
/// epsilon is needed.
template <typename Real>
PARRAY_INLINE MaskOf<Real> enters(const Ray<Real>& ray, const SphereShape<Real>& sphere, Real& t) {
  const ClosestApproach<Real> passage(ray, sphere);
  t = entry_distance(passage.foot, passage.depth_squared, ray.inverse_square);
  return passage.approaches();
}

/// Returns the ray parameter, >= 0, at which a ray from inside leaves a sphere. Such a ray always
/// leaves. Only an event of its material lets a path leave a sphere, never a rounding error.
template <typename Real>
PARRAY_INLINE Real exit_distance(const Ray<Real>& ray, const SphereShape<Real>& sphere) {
  const ClosestApproach<Real> passage(ray, sphere);
  return max_of(passage.foot + passage.half_chord(ray), Real(0));
}

/// Returns exit_distance() for a ray that starts on the sphere's surface, at outward unit normal
/// `normal`: the other end of the chord, without cancellation.
template <typename Real>
PARRAY_INLINE Real chord_from_surface(const Ray<Real>& ray, const SphereShape<Real>& sphere,
                                      const Vec3<Real>& normal) {
  const Real t = Real(-2) * sphere.radius * dot(normal, ray.direction) * ray.inverse_square;
  return max_of(t, Real(0));
}

/// Returns the outward unit normal where the line of `ray` enters (`leaving` false) or leaves the
/// sphere. The normal is computed from the perpendicular, because origin + t direction cancels at a
/// distance.
template <typename Real, typename Mask>
PARRAY_INLINE Vec3<Real> normal_at(const Ray<Real>& ray, const SphereShape<Real>& sphere,
                                   Mask leaving) {
  const ClosestApproach<Real> passage(ray, sphere);
  const Real half_chord = passage.half_chord(ray);
  const Real along = select(leaving, half_chord, -half_chord);
  return normalize(along * ray.direction - passage.perpendicular);
}

/// Returns normal_at() with `leaving` false.
template <typename Real>
PARRAY_INLINE Vec3<Real> normal_entering(const Ray<Real>& ray, const SphereShape<Real>& sphere) {
  const ClosestApproach<Real> passage(ray, sphere);
  return normalize(-passage.half_chord(ray) * ray.direction - passage.perpendicular);
}

}  // namespace parray::trace
