#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "cli/check/doctor/check.h"
#include "common/trace/sphere.h"

/// Measures how far the hits that sphere.h finds are from the surface.
namespace parray::doctor {

/// Returns the distance of the ray's origin from the centre, in radii.
template <typename Wide, typename Real>
Wide distance_in_radii(const Ray<Real>& ray, const SphereShape<Real>& sphere) {
  const Vec3<Real>& o = ray.origin;
  const Vec3<Real>& c = sphere.center;
  const Wide x = static_cast<Wide>(o.x) - c.x;
  const Wide y = static_cast<Wide>(o.y) - c.y;
  const Wide z = static_cast<Wide>(o.z) - c.z;
  return std::sqrt(x * x + y * y + z * z) / sphere.radius;
}

/// Returns the distance from the surface of the ray's point at `t`, in radii, divided by ulp(S) of
/// `Store`. S is the larger of 1 and the distance of the ray's origin from the centre in radii;
/// ulp(S) is S times the distance from 1 to the next larger `Store`.
/// `Store`: type of the stored sphere, `Real`: type in which the hit was computed. `Wide` has
/// several bits more than `Real`.
template <typename Wide, typename Store, typename Real>
double backward_error(const Ray<Real>& ray, const SphereShape<Real>& sphere, Real t) {
  const auto along = [t](Real from, Real direction, Real center) {
    return static_cast<Wide>(from) - static_cast<Wide>(center) +
           static_cast<Wide>(t) * static_cast<Wide>(direction);
  };
  const Vec3<Real>& o = ray.origin;
  const Vec3<Real>& d = ray.direction;
  const Vec3<Real>& c = sphere.center;
  const Wide x = along(o.x, d.x, c.x);
  const Wide y = along(o.y, d.y, c.y);
  const Wide z = along(o.z, d.z, c.z);
  const Wide radius = sphere.radius;
  const Wide reached = std::sqrt(x * x + y * y + z * z);
  const Wide ulp = 2 * static_cast<Wide>(RealTraits<Store>::unit_roundoff) *
                   std::max(Wide(1), distance_in_radii<Wide>(ray, sphere));
  return static_cast<double>(std::abs(reached - radius) / radius / ulp);
}

/// The largest backward_error() of many hits, for each precision. f32 and mixed are in ulp(S) of
/// float, f64 is in ulp(S) of double.
struct HitErrors {
  double f32 = 0;
  double mixed = 0;
  double f64 = 0;
  std::uint64_t hits = 0;  ///< in all precisions together
};

/// Traces `rays` random rays in each precision, from outside at spheres with radii of 1e-12 to
/// 1e12. Every call uses the same random numbers.
HitErrors worst_hit_errors(std::uint64_t rays);

/// Fails if there are no hits, or an error is above its bound: 8 in f32 and f64, 2 in mixed.
CheckResult check_hit_errors(const HitErrors& worst);

}  // namespace parray::doctor
