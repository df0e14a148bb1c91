#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

#include "cli/check/doctor/check.h"
#include "cli/check/doctor/rounding_cases.h"
#include "cli/check/doctor/tracing.h"
#include "common/image/pixel_sums.h"
#include "common/trace/sphere.h"

/// Numerical extremes for `parray doctor --extremes`: scenes and operands for which the result is
/// known exactly. A check fails if any result differs. `make` makes the tracers to check: those of
/// one instruction set. Each check that traces does so in every precision, with linear search and
/// with the BVH. tests/extremes has more cases of the same scenes.
namespace parray::doctor {

// ---- Scenes whose samples are known exactly, also for tests/extremes -------------------------

/// Returns settings of a picture with `samples` per pixel (more than 2^24 count as 2^24) and the
/// max_depth `depth`.
RenderSettings sized(std::uint32_t width, std::uint32_t height, std::uint64_t samples,
                     std::uint32_t depth);

/// Returns an empty scene under a sky of radiance 1, with a pinhole camera.
Scene under_white_sky();

/// Returns a white and a mirror ball that touch, and a glass ball with a bubble. Every sample is 1
/// if no path reaches max_depth: set max_depth to about 2^16.
Scene white_balls();

/// Returns a white ball of `radius` around the camera, which is `off_centre` radii from its centre:
/// 0 to below 1.
/// Every sample is 0, and every path has max_depth segments.
Scene closed_ball(double radius, double off_centre);

/// Returns a grey ball of `radius` that fills a square picture. Every sample is 1/2, and every path
/// has two segments: no path meets the surface that it leaves.
Scene grey_ball(double radius);

/// Multiplies all lengths of `scene` by 2^k. `scene` must not have capsules. The picture keeps its
/// bits unless numbers overflow or become denormal.
Scene scaled(Scene scene, int k);

/// Returns the number of pixels that are not exactly the sum of `samples` samples, each with the
/// radiance `fixed` in every channel. `fixed` is in fixed point, 2^32 for the radiance 1.
std::size_t pixels_other_than(const std::vector<PixelSums>& pixels, std::uint64_t fixed,
                              std::uint64_t samples);

// ---- Checks ----------------------------------------------------------------------------------

/// Traces white_balls() and closed_ball(). Every sample of white_balls() must be exactly 1. Every
/// sample of closed_ball() must be exactly 0, and every path must have max_depth segments.
CheckResult check_furnaces(const TracerMaker& make);

/// Traces grey_ball(). Every path must have two segments, and every sample must be exactly 1/2.
CheckResult check_self_hits(const TracerMaker& make);

/// Traces doctor_scene() scaled by 2^-40, 1 and 2^40. The sums must be those of scalar code
/// (path.h) for the unscaled scene.
CheckResult check_scaling(const TracerMaker& make);

/// Computes + - x / sqrt of hard cases in every OpenMP thread, in the floating-point mode of
/// tracing (FloatMode).
CheckResult check_rounding(std::span<const RoundingCase<std::uint32_t>> singles = single_cases,
                           std::span<const RoundingCase<std::uint64_t>> doubles = double_cases);

// ---- How far the hits that sphere.h finds are from the surface -------------------------------

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
