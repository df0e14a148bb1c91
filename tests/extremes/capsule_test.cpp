// One ray and one capsule, over 24 decades of radius and 12 of length. The oracle is exact for the
// stored numbers of both (capsule_cases.h, 113 bits).
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>

#include "tests/support/capsule_cases.h"
#include "tests/support/extremes.h"
#include "tests/support/sphere_cases.h"

namespace parray::test {
namespace {

/// Worst errors of rays from outside, in ulp of the largest coordinate.
struct WorstPassage {
  double at_t = 0;     ///< height of the ray's point at the computed t
  double surface = 0;  ///< height of the computed surface point
  double normal = 0;   ///< from unit length
  double band = 0;     ///< distance from tangency of a wrong decision
  double before = 0;   ///< depth of the ray before the computed entry
  int hits = 0;
  int misses = 0;

  template <typename Real>
  void look_at(const Ray<Real>& ray, const CapsuleShape<Real>& capsule) {
    const ExactCapsule<Real> truth(ray, capsule);
    if (truth.starts_inside()) {
      look_from_inside(ray, capsule, truth);
      return;
    }
    Real t = 0;
    const bool hit = enters(ray, capsule, t);
    ++(hit ? hits : misses);
    const double lowest = truth.lowest();
    if (hit != (lowest < 0)) band = std::max(band, std::abs(lowest));
    if (!hit) return;
    at_t = std::max(at_t, std::abs(truth.height(truth.at(t))));
    before = std::max(before, truth.depth_before(t));
    look_at_point(truth, surface_point(ray, capsule, false));
  }

 private:
  template <typename Real>
  void look_from_inside(const Ray<Real>& ray, const CapsuleShape<Real>& capsule,
                        const ExactCapsule<Real>& truth) {
    at_t = std::max(at_t, std::abs(truth.height(truth.at(exit_distance(ray, capsule)))));
    look_at_point(truth, surface_point(ray, capsule, true));
  }
  template <typename Real>
  void look_at_point(const ExactCapsule<Real>& truth, const SurfacePoint<Real>& point) {
    surface = std::max(surface, std::abs(truth.height(exact(point.position()))));
    normal = std::max(normal, unit_error(point.normal));
  }
};

}  // namespace

TEST_CASE_TEMPLATE("a ray meets a capsule within 6 ulp of its surface, at every size and length",
                   Real, float, double) {
  Dice dice(seeded(201));
  WorstPassage worst;
  for (std::uint64_t i = 0; i < trials(5'000); ++i) {
    const CapsuleShape<Real> capsule = any_capsule<Real>(dice, 12);
    const double impact = dice.one_in(2) ? dice.between(0, 1.2) : 1 + dice.between(-1e-6, 1e-6);
    worst.look_at(ray_at(dice, capsule, impact, 1e4), capsule);
  }
  CHECK(worst.hits > 1500);
  CHECK(worst.misses > 300);
  within(41, named<Real>("capsules: the ray's point at t / ulp"), worst.at_t, 6);
  within(41, named<Real>("capsules: the surface point / ulp"), worst.surface, 2);
  within(41, named<Real>("capsules: depth before the entry / ulp"), worst.before, 6);
  within(41, named<Real>("capsules: wrong decisions, from tangency / ulp"), worst.band, 3);
  within(41, named<Real>("capsules: length of normals / ulp"), worst.normal, 4);
}

TEST_CASE_TEMPLATE(
    "a ray along the axis enters a capsule by the nearer end and leaves by the other", Real, float,
    double) {
  WorstPassage worst;
  for (const double side : {-1, 1}) {
    for (const Vec3d& axis : {Vec3d{1, 0, 0}, Vec3d{0, 1, 0}, Vec3d{0, 0, 1}}) {
      for (int power = -10; power <= 10; ++power) {
        // Powers of two, so that no rounding turns the ray away from the axis.
        const double half = std::ldexp(1.0, power);
        const CapsuleShape<Real> capsule{{}, vec_cast<Real>(half * axis), static_cast<Real>(0.75)};
        const Vec3d beside{0.25 * axis.y, 0.25 * axis.z, 0.25 * axis.x};
        const auto direction = vec_cast<Real>(side * axis);
        const Vec3d outside = -side * (half + 2) * axis + beside;
        worst.look_at(Ray<Real>(vec_cast<Real>(outside), direction), capsule);
        worst.look_at(Ray<Real>(vec_cast<Real>(beside), direction), capsule);
      }
    }
  }
  CHECK(worst.hits == 2 * 3 * 21);
  CHECK(worst.misses == 0);
  CHECK(worst.at_t < 6);
  CHECK(worst.surface < 2);
}

TEST_CASE_TEMPLATE("a capsule scaled by a power of two is met at the scaled distance, bit for bit",
                   Real, float, double) {
  Dice dice(seeded(203));
  for (std::uint64_t i = 0; i < trials(3'000); ++i) {
    const CapsuleShape<Real> capsule = any_capsule<Real>(dice, 2);
    const Ray<Real> ray = ray_at(dice, capsule, dice.between(0, 1.1), 1e3);
    const auto factor = static_cast<Real>(std::ldexp(1.0, static_cast<int>(dice.between(-8, 8))));
    const CapsuleShape<Real> scaled{factor * capsule.middle, factor * capsule.half,
                                    factor * capsule.radius};
    const Ray<Real> moved(factor * ray.origin, ray.direction);
    Real t = 0;
    Real scaled_t = 0;
    const bool met = enters(ray, capsule, t);
    REQUIRE(enters(moved, scaled, scaled_t) == met);
    if (met) REQUIRE(scaled_t == factor * t);
    if (met) {
      REQUIRE(surface_point(moved, scaled, false).normal ==
              surface_point(ray, capsule, false).normal);
    }
  }
}

}  // namespace parray::test
