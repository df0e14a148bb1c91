#pragma once

#include "common/trace/sphere.h"

/// Capsules: all points within a radius of a segment. A capsule is convex, so the rules of
/// inside_stack.h hold for it as for a sphere.
///
/// Notation: M is the middle of the segment, v half of it, r the radius. The segment is M + z v
/// with z in [-1, 1]. The ray is o + t d. u is the unit roundoff of the real type.
///
/// t0 is the parameter of the line's point nearest to M, and q = (M - o) - t0 d. All further
/// vectors start there, as for spheres: subtracting before squaring keeps cancellation away. Taking
/// off the parts along v gives w = q - (q.v / v.v) v and p = d - (d.v / v.v) v. The distance of the
/// line from the axis at t0 + s is |w - s p|, least at s = w.p / p.p. So the line meets the side
/// at s -+ sqrt((r^2 - e.e) / p.p) with e = w - s p.
///
/// Error [measured against 113 bits, half length / radius 1e-6 to 1e6, tilts to 1e-18, any scale;
/// tests/extremes/capsule_test.cpp]: the point at the computed t is within 11 u of the largest
/// coordinate from the capsule, the surface point within 4 u. The decision between hit and miss is
/// wrong only within 2 u max(length, distance) of tangency.
namespace parray::trace {

/// `half` is zero or not shorter than limits::min_radius. So 1 / v.v is finite and normal.
template <typename Real>
struct CapsuleShape {
  Vec3<Real> middle;
  Vec3<Real> half;  ///< from the middle to one end of the segment
  Real radius;
};

/// Converts the type of a shape's numbers.
template <typename To, typename From>
PARRAY_INLINE CapsuleShape<To> shape_cast(const CapsuleShape<From>& capsule) {
  return {vec_cast<To>(capsule.middle), vec_cast<To>(capsule.half),
          static_cast<To>(capsule.radius)};
}

/// A point where a line crosses the surface of a capsule.
template <typename Real>
struct CapsuleCrossing {
  Real t;  ///< ray parameter, >= 0
  SurfacePoint<Real> point;
};

/// A line beside a capsule. With lanes, one line and one capsule in each lane. Refers to the ray
/// and the capsule, which must outlive it.
template <typename Real>
class CapsulePassage {
 public:
  PARRAY_INLINE CapsulePassage(const Ray<Real>& ray, const CapsuleShape<Real>& capsule)
      : ray_(ray), capsule_(capsule) {
    const Real zero(0);
    const Vec3<Real>& d = ray.direction;
    const Vec3<Real>& v = capsule.half;
    const Vec3<Real> to_middle = capsule.middle - ray.origin;
    foot_ = dot(to_middle, d) * ray.inverse_square;
    q_ = to_middle - foot_ * d;
    const Real square = dot(v, v);
    const Real inverse = select(square > zero, Real(1) / square, zero);  // 0: a sphere
    q_along_ = dot(q_, v) * inverse;
    d_along_ = dot(d, v) * inverse;
    const Vec3<Real> w = q_ - q_along_ * v;
    p_ = d - d_along_ * v;
    p_square_ = dot(p_, p_);
    nearest_ = select(p_square_ >= least_square(), dot(w, p_) / p_square_, zero);
    e_ = w - nearest_ * p_;
  }

  /// Returns whether a ray that starts outside enters the capsule: whether its line meets the
  /// sphere around the point of the segment that is nearest to the line, ahead of the origin.
  [[nodiscard]] PARRAY_INLINE MaskOf<Real> approaches() const {
    const Real one(1);
    const Real z = min_of(max_of(nearest_ * d_along_ - q_along_, -one), one);
    const Vec3<Real> off = q_ + z * capsule_.half;
    const Real further = dot(off, ray_.direction) * ray_.inverse_square;
    const Vec3<Real> apart = off - further * ray_.direction;
    return (foot_ + further > Real(0)) & (capsule_.radius * capsule_.radius >= dot(apart, apart));
  }

  /// Returns where the line enters the capsule, or leaves it where `leaving` is set. The line must
  /// meet the capsule, except for rounding.
  [[nodiscard]] PARRAY_INLINE CapsuleCrossing<Real> crossing(auto leaving) const {
    const Real one(1);
    const Real zero(0);
    const Real room = max_of(capsule_.radius * capsule_.radius - dot(e_, e_), zero);
    const Real half_chord = square_root(room / p_square_);
    const Real along = select(leaving, half_chord, -half_chord);
    const Real z = (nearest_ + along) * d_along_ - q_along_;
    const MaskOf<Real> on_side = (z <= one) & (z >= -one) & (p_square_ >= least_square());
    // A line along the axis crosses the end that it points to last.
    const Real side = select(p_square_ >= least_square(), z, select(leaving, d_along_, -d_along_));
    const Vec3<Real> end = capsule_.middle + select(side > zero, one, -one) * capsule_.half;
    const ClosestApproach<Real> cap(ray_, SphereShape<Real>{end, capsule_.radius});
    const Real cap_half = cap.half_chord(ray_);
    const Real cap_along = select(leaving, cap_half, -cap_half);
    const Vec3<Real> outward =
        select(on_side, along * p_ - e_, cap_along * ray_.direction - cap.perpendicular);
    const Real t = foot_ + nearest_ + along;
    return {max_of(select(on_side, t, cap.foot + cap_along), zero),
            {normalize(outward), select(on_side, capsule_.middle + z * capsule_.half, end),
             capsule_.radius}};
  }

 private:
  /// Returns the least p.p: below it, the line counts as parallel to the axis.
  static PARRAY_INLINE Real least_square() {
    constexpr auto u = RealTraits<Real>::unit_roundoff;
    return Real(u * u * u * u);
  }

  const Ray<Real>& ray_;
  const CapsuleShape<Real>& capsule_;
  Real foot_;               ///< t0
  Vec3<Real> q_;            ///< from the line's point at t0 to M
  Real q_along_, d_along_;  ///< q.v / v.v and d.v / v.v
  Vec3<Real> p_;
  Real p_square_;
  Real nearest_;  ///< s
  Vec3<Real> e_;  ///< from the line to the axis
};

/// Finds the point where a ray from outside enters a capsule: see enters() of sphere.h.
template <typename Real>
PARRAY_INLINE MaskOf<Real> enters(const Ray<Real>& ray, const CapsuleShape<Real>& capsule,
                                  Real& t) {
  const CapsulePassage<Real> passage(ray, capsule);
  t = passage.crossing(Real(0) > Real(0)).t;
  return passage.approaches();
}

/// Returns the ray parameter, >= 0, at which a ray from inside leaves a capsule. Such a ray always
/// leaves: see exit_distance() of sphere.h. It may start on the surface.
template <typename Real>
PARRAY_INLINE Real exit_distance(const Ray<Real>& ray, const CapsuleShape<Real>& capsule) {
  return CapsulePassage<Real>(ray, capsule).crossing(Real(1) > Real(0)).t;
}

/// Returns the point where the line of `ray` enters the capsule, or leaves it where `leaving` is
/// set.
template <typename Real, typename Mask>
PARRAY_INLINE SurfacePoint<Real> surface_point(const Ray<Real>& ray,
                                               const CapsuleShape<Real>& capsule, Mask leaving) {
  return CapsulePassage<Real>(ray, capsule).crossing(leaving).point;
}

/// Returns whether a point lies inside a capsule.
template <typename Real>
PARRAY_INLINE MaskOf<Real> contains(const CapsuleShape<Real>& capsule, const Vec3<Real>& point) {
  const Real one(1);
  const Real zero(0);
  const Vec3<Real>& v = capsule.half;
  const Vec3<Real> from_middle = point - capsule.middle;
  const Real square = dot(v, v);
  const Real z = select(square > zero, dot(from_middle, v) / square, zero);
  const Vec3<Real> off = from_middle - min_of(max_of(z, -one), one) * v;
  return dot(off, off) < capsule.radius * capsule.radius;
}

}  // namespace parray::trace
