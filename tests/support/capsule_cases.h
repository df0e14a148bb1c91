#pragma once

#include <algorithm>
#include <cmath>

#include "common/trace/capsule.h"
#include "tests/support/dice.h"
#include "tests/support/quad.h"
#include "tests/support/rooms.h"

/// Single rays and capsules, with exact answers for their stored numbers.
namespace parray::test {

template <typename Real>
struct CapsuleCase {
  CapsuleShape<Real> capsule;
  Ray<Real> ray;
};

/// Makes a capsule with a radius from 10^-decades to 10^decades, a half length of 10^-6 to 10^6
/// radii, or none, and its middle up to a million radii from 0.
template <typename Real>
CapsuleShape<Real> any_capsule(Dice& dice, double decades) {
  const double r = dice.ten_to(-decades, decades);
  const double offset = dice.one_in(4) ? 0 : std::min(dice.ten_to(-3, 6) * r, 1e15);
  const double half = dice.one_in(8) ? 0 : std::clamp(dice.ten_to(-6, 6) * r, 1e-15, 1e15);
  const Vec3d along = dice.one_in(4) ? Vec3d{0, 1, 0} : dice.direction();
  return {vec_cast<Real>(offset * dice.direction()), vec_cast<Real>(half * along),
          static_cast<Real>(r)};
}

/// Makes a ray from a point up to `farthest` radii from the segment towards a point at `impact`
/// radii from it. One ray in four runs along the axis, but for a tilt of 10^-18 to 1.
template <typename Real>
Ray<Real> ray_at(Dice& dice, const CapsuleShape<Real>& capsule, double impact, double farthest) {
  const Vec3d middle = vec_cast<double>(capsule.middle);
  const Vec3d half = vec_cast<double>(capsule.half);
  const auto r = static_cast<double>(capsule.radius);
  const auto near = [&](double distance) {
    return middle + dice.between(-1.1, 1.1) * half + (distance * r) * dice.direction();
  };
  const Vec3d from = near(dice.ten_to(-1, std::log10(farthest)));
  Vec3d towards = near(impact) - from;
  if (dice.one_in(4) && length(half) > 0) {
    towards = normalize(half) + dice.ten_to(-18, 0) * dice.direction();
  }
  return {vec_cast<Real>(from), vec_cast<Real>(normalize(towards))};
}

/// The exact answers. The unit of all errors is an ulp of the largest coordinate of the case.
template <typename Real>
class ExactCapsule {
 public:
  ExactCapsule(const Ray<Real>& ray, const CapsuleShape<Real>& capsule)
      : from_(exact(ray.origin)),
        direction_(exact(ray.direction)),
        middle_(exact(capsule.middle)),
        half_(exact(capsule.half)),
        radius_(capsule.radius) {
    Quad largest = radius_;
    for (const QuadVec& v : {from_, middle_, half_}) {
      largest = std::max({largest, quad_abs(v.x), quad_abs(v.y), quad_abs(v.z)});
    }
    ulp_ = 2 * static_cast<Quad>(RealTraits<Real>::unit_roundoff) * largest;
  }

  /// Returns the distance of a point from the surface, in ulp; negative inside.
  [[nodiscard]] double height(const QuadVec& point) const {
    return static_cast<double>((distance_from_segment(point) - radius_) / ulp_);
  }
  [[nodiscard]] bool starts_inside() const { return distance_from_segment(from_) <= radius_; }
  [[nodiscard]] QuadVec at(Real t) const { return from_ + static_cast<Quad>(t) * direction_; }

  /// Returns the height of the lowest point of the ray, in ulp: where it is negative, the ray
  /// enters. The height is convex along the ray, so that golden sections find it.
  [[nodiscard]] double lowest() const {
    const Quad reach = 4 * (quad_length(from_ - middle_) + quad_length(half_) + radius_);
    Quad low = 0;
    Quad high = reach;
    const Quad golden = Quad(0.381966011250105L);
    for (int step = 0; step < 160; ++step) {
      const Quad a = low + golden * (high - low);
      const Quad b = high - golden * (high - low);
      (distance_at(a) < distance_at(b) ? high : low) = distance_at(a) < distance_at(b) ? b : a;
    }
    return static_cast<double>((distance_at(low) - radius_) / ulp_);
  }

  /// Returns the deepest point between 0 and `t`, in ulp below the surface: a crossing at `t` must
  /// be the first one.
  [[nodiscard]] double depth_before(Real t) const {
    double deepest = 0;
    for (int k = 1; k < 16; ++k) {
      const QuadVec point = from_ + (static_cast<Quad>(t) * k / 16) * direction_;
      deepest = std::max(deepest, -height(point));
    }
    return deepest;
  }

 private:
  [[nodiscard]] Quad distance_at(Quad t) const {
    return distance_from_segment(from_ + t * direction_);
  }
  [[nodiscard]] Quad distance_from_segment(const QuadVec& point) const {
    const QuadVec off = point - middle_;
    const Quad square = dot(half_, half_);
    const Quad along = square > 0 ? dot(off, half_) / square : Quad(0);
    const Quad z = along > 1 ? Quad(1) : along < -1 ? Quad(-1) : along;
    return quad_length(off - z * half_);
  }

  QuadVec from_;
  QuadVec direction_;
  QuadVec middle_;
  QuadVec half_;
  Quad radius_;
  Quad ulp_;
};

}  // namespace parray::test
