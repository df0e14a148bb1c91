// Rows 1 to 16 of the table of numerical extremes: one ray and one sphere. The oracle is exact for
// the stored numbers of ray and sphere (sphere_oracle.h, 113 bits).
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "common/scene/limits.h"
#include "tests/support/extremes.h"
#include "tests/support/lane_search.h"
#include "tests/support/rooms.h"
#include "tests/support/sphere_cases.h"

namespace parray::test {
namespace {

/// Makes a ray that passes the sphere at 1 + `steps` ulp(S) radii. |direction| = 1, and distances
/// cover all S.
template <typename Real>
SphereCase<Real> grazing_case(Dice& dice, const SphereShape<Real>& sphere, double steps) {
  const double distance = dice.ten_to(0.01, 6);
  const double ulp = 2 * static_cast<double>(RealTraits<Real>::unit_roundoff) * distance;
  return aimed_case(dice, sphere, 1 + steps * ulp, distance, 1);
}

/// A random orthonormal frame, so that no computation is exact by chance.
struct Frame {
  explicit Frame(Dice& dice) : along(dice.direction()), right(dice.across(along)) {
    up = cross(along, right);
  }
  Vec3d along;
  Vec3d right;
  Vec3d up;
};

/// Traces parallel rays towards a unit sphere from `distance` radii. Returns the largest distance
/// from tangency of a line with a wrong answer. Sets `hits` to the number of hits.
template <typename Real>
double worst_of_grid(Dice& dice, double distance, int side, int& hits) {
  const Frame frame(dice);
  const SphereShape<Real> sphere{{0, 0, 0}, 1};
  double band = 0;
  for (int i = 0; i < side * side; ++i) {
    const double x = 1.1 * (2.0 * (i % side) / (side - 1) - 1);
    const double y = 1.1 * (2.0 * (i / side) / (side - 1) - 1);
    const Vec3d from = x * frame.right + y * frame.up - distance * frame.along;
    const Ray<Real> ray(vec_cast<Real>(from), vec_cast<Real>(frame.along));
    const Exact<Real> truth(ray, sphere);
    Real t = 0;
    const bool hit = enters(ray, sphere, t);
    hits += hit ? 1 : 0;
    band = std::max(band, hit == truth.enters() ? 0.0 : truth.tangency());
  }
  return band;
}

/// Errors of lanes that search for one sphere. The unit is an ulp of `Ulp`; sums are computed in
/// P::Real.
struct LaneErrors {
  double backward = 0;
  double forward = 0;
  double band = 0;
  double speck = 0;  ///< the band of spheres with a radius below 4 ulp(S)
};

template <typename P>
void judge(LaneSearch<typename P::Real>& search, const SphereShape<typename P::Real>& sphere,
           const std::vector<Query<typename P::Real>>& queries, LaneErrors& worst) {
  const auto hits = search.find(queries);
  for (std::size_t i = 0; i < queries.size(); ++i) {
    const Exact<typename P::Real> truth(queries[i].ray, sphere);
    if (truth.distance <= truth.radius) continue;
    const bool hit = hits[i].shape == 0;
    if (hit != truth.enters()) {
      double& band = truth.ulp <= Quad(0.25) ? worst.band : worst.speck;
      band = std::max(band, truth.tangency());
    } else if (hit) {
      worst.backward = std::max(worst.backward, truth.backward_error(hits[i].t));
      worst.forward =
          std::max(worst.forward, truth.forward_error(hits[i].t, truth.foot - truth.half_chord));
    }
  }
}

template <typename P>
LaneErrors worst_of_lanes(Isa isa, std::uint64_t spheres) {
  using Real = typename P::Real;
  using Store = typename P::Store;
  Dice dice(seeded(101));
  LaneErrors worst;
  for (std::uint64_t s = 0; s < spheres; ++s) {
    const SphereShape<Store> stored = any_sphere<Store>(dice, 12);
    const SphereShape<Real> sphere{vec_cast<Real>(stored.center), static_cast<Real>(stored.radius)};
    const auto search = lane_search<P>(isa, {stored}, false, false);
    std::vector<Query<Real>> queries(256);
    const double most = std::min(1e7, 1e15 / static_cast<double>(sphere.radius));
    for (Query<Real>& query : queries) {
      const double distance = 1.0001 * std::pow(std::max(most, 1.0), dice.unit());
      const double impact = dice.one_in(2) ? dice.between(0, 1.1) : 1 - dice.ten_to(-12, -1);
      query.ray = aimed_case(dice, sphere, impact, distance, dice.ten_to(-6, 6)).ray;
      query.sides.start();
    }
    judge<P>(*search, sphere, queries, worst);
  }
  return worst;
}

}  // namespace

TEST_CASE(
    "row 1: entries err by at most 8 ulp(S) over 24 decades of radii, in f64 by 2^-27 of f32") {
  std::array<WorstEntry, 2> worst;
  Dice dice(seeded(1));
  for (std::uint64_t i = 0; i < trials(100'000); ++i) {
    const double impact = dice.between(0, 1.1);
    worst[0].look_at(sphere_case<float>(dice, 12, impact, 1.0001, 1e7));
    worst[1].look_at(sphere_case<double>(dice, 12, impact, 1.0001, 1e7));
  }
  for (const std::size_t k : {0U, 1U}) {
    const std::string name = k == 0 ? ", f32" : ", f64";
    within(1, "backward error of the entry / ulp(S)" + name, worst[k].backward, 8);
    within(1, "forward error x sqrt(1 - b^2) / ulp(S)" + name, worst[k].forward, 8);
    within(1, "hit or miss wrong: distance from tangency / ulp(S)" + name, worst[k].band, 2);
    within(1, "the same of spheres smaller than 4 ulp of their distance" + name, worst[k].speck, 3);
    within(1, "error of the normal x sqrt(1 - b^2) / ulp(S)" + name, worst[k].normal, 8);
    within(16, "unit length of normals / ulp" + name, worst[k].unit, 2);
    CHECK(worst[k].hits > 60'000);
    CHECK(worst[k].misses > 4'000);
  }
  // In the same unit: an ulp of f64 is 2^-29 ulp of f32.
  within(1, "worst backward error, f64 / f32 x 2^27", 0.25 * worst[1].backward / worst[0].backward,
         1);
  within(1, "worst forward error, f64 / f32 x 2^27", 0.25 * worst[1].forward / worst[0].forward, 1);
}

TEST_CASE("row 1: lanes of every instruction set keep the error bounds in every precision") {
  constexpr double f64_in_f32 = 0x1p-29;
  for (const Isa isa : instruction_sets()) {
    CAPTURE(name_of(isa));
    const std::string name = ", " + std::string(name_of(isa));
    const LaneErrors single = worst_of_lanes<SinglePrecision>(isa, trials(30));
    within(1, "backward error / ulp(S), f32" + name, single.backward, 8);
    within(1, "forward error x sqrt(1 - b^2) / ulp(S), f32" + name, single.forward, 8);
    within(1, "tangency of wrong answers / ulp(S), f32" + name, single.band, 2);
    within(1, "the same of spheres smaller than 4 ulp of their distance, f32" + name, single.speck,
           3);
    const LaneErrors mixed = worst_of_lanes<MixedPrecision>(isa, trials(30));
    within(1, "backward error / f32 ulp(S), mixed" + name, mixed.backward * f64_in_f32, 2);
    within(1, "forward error x sqrt(1 - b^2) / f32 ulp(S), mixed" + name,
           mixed.forward * f64_in_f32, 2);
    within(1, "tangency of wrong answers / (2^-40 S), mixed" + name, mixed.band * 0x1p-12, 1);
    const LaneErrors whole = worst_of_lanes<DoublePrecision>(isa, trials(30));
    within(1, "backward error / ulp(S), f64" + name, whole.backward, 8);
    within(1, "forward error x sqrt(1 - b^2) / ulp(S), f64" + name, whole.forward, 8);
    within(1, "tangency of wrong answers / ulp(S), f64" + name, whole.band, 2);
  }
}

TEST_CASE_TEMPLATE("row 2: answers for grazing rays are wrong only within 2 ulp(S)", Real, float,
                   double) {
  Dice dice(seeded(2));
  double band = 0;
  int wrong = 0;
  for (std::uint64_t i = 0; i < trials(1000); ++i) {
    const SphereShape<Real> sphere = any_sphere<Real>(dice, 3);
    for (int k = -64; k <= 64; ++k) {
      const SphereCase<Real> c = grazing_case(dice, sphere, k / 4.0);
      const Exact<Real> truth(c.ray, c.sphere);
      Real t = 0;
      if (enters(c.ray, c.sphere, t) != truth.enters() && truth.foot > 0) {
        ++wrong;
        band = std::max(band, truth.tangency());
      }
    }
  }
  within(2, named<Real>("hit or miss wrong: distance from tangency / ulp(S)"), band, 2);
  CHECK(wrong > 100);  // the rays are really as near to the tangent
}

TEST_CASE_TEMPLATE("row 2: with growing impact, no hit follows a miss", Real, float, double) {
  Dice dice(seeded(3));
  double again = 0;
  for (std::uint64_t i = 0; i < trials(3000); ++i) {
    const auto radius = static_cast<Real>(dice.ten_to(-6, 6));
    const SphereShape<Real> sphere{{0, 0, 0}, radius};
    const Real away = radius * static_cast<Real>(dice.ten_to(0.1, 6));
    Real impact = radius * (1 - 64 * RealTraits<Real>::unit_roundoff);
    bool missed = false;
    for (int k = 0; k < 128; ++k) {
      Real t = 0;
      const bool hit = enters(Ray<Real>({-away, impact, 0}, {1, 0, 0}), sphere, t);
      again += hit && missed ? 1 : 0;
      missed = missed || !hit;
      impact = std::nextafter(impact, 2 * radius);
    }
    CHECK(missed);
  }
  within(2, named<Real>("hits behind a miss along b"), again, 0);
}

TEST_CASE_TEMPLATE("row 5: the disc of a unit sphere is correct from 100 to a million radii away",
                   Real, float, double) {
  Dice dice(seeded(5));
  const int side = static_cast<int>(std::sqrt(static_cast<double>(trials(96 * 96))));
  std::vector<double> distances{100, 2000, 4100, 8000, 1e5, 1e6};
  if (sizeof(Real) == sizeof(double)) distances.push_back(0x1p27);
  double band = 0;
  for (const double distance : distances) {
    int hits = 0;
    band = std::max(band, worst_of_grid<Real>(dice, distance, side, hits));
    const double share = static_cast<double>(hits) / side / side;
    // If an ulp is 1/16 of a radius, rays no longer start at their exact places.
    CHECK(share == doctest::Approx(3.14159265 / 4.84).epsilon(0.02));
  }
  within(5, named<Real>("far disc: tangency of wrong pixels / ulp(S)"), band, 2);
}

TEST_CASE_TEMPLATE("row 6: half a metre above the Earth the ground is below, not on the far side",
                   Real, float, double) {
  constexpr double earth = 6.371e6;
  const SphereShape<Real> sphere{{0, 0, 0}, Real(earth)};
  const Vec3<Real> eye{0, Real(earth + 0.5), 0};
  Real t = 0;
  REQUIRE(enters(Ray<Real>(eye, {0, -1, 0}), sphere, t));
  const bool single = sizeof(Real) == sizeof(float);
  within(6, named<Real>("straight down: |t - 0.5| / m"), std::abs(static_cast<double>(t) - 0.5),
         single ? 0.5 : 1e-9);
  // The horizon lies sqrt(2 h / r) below the horizontal.
  Dice dice(seeded(6));
  WorstEntry worst;
  for (std::uint64_t i = 0; i < trials(20'000); ++i) {
    const double dip = std::sqrt(1 / earth) * (1 + dice.sign() * dice.ten_to(-7, 0.3));
    const Vec3d level{std::cos(dip), -std::sin(dip), 0};
    worst.look_at(SphereCase<Real>{sphere, {eye, vec_cast<Real>(level)}});
  }
  within(6, named<Real>("at the horizon: backward error / ulp(S)"), worst.backward, 8);
  within(6, named<Real>("at the horizon: tangency of wrong answers / ulp(S)"), worst.band, 2);
  CHECK(worst.hits > 1000);
  CHECK(worst.misses > 1000);
}

TEST_CASE_TEMPLATE("row 7: points on a ground of radius 1000 stand on it to 4 ulp", Real, float,
                   double) {
  const SphereShape<Real> ground{{0, -1000, 0}, 1000};
  const double ulp = 1024 * static_cast<double>(RealTraits<Real>::unit_roundoff);
  const Vec3<Real> eye{13, 2, 3};
  Dice dice(seeded(7));
  double worst = 0;
  int hits = 0;
  for (std::uint64_t i = 0; i < trials(30'000); ++i) {
    const Vec3d target{dice.between(-10, 10), 0, dice.between(-10, 10)};
    const Ray<Real> ray(eye, normalize(vec_cast<Real>(target - vec_cast<double>(eye))));
    Real t = 0;
    if (enters(ray, ground, t)) {
      ++hits;
      const Vec3<Real> n = normal_at(ray, ground, false);
      const Vec3<Real> p = ground.center + ground.radius * n;  // as the tracer does
      const Quad off = quad_length(exact(p) - exact(ground.center)) - Quad(1000);
      worst = std::max(worst, static_cast<double>(quad_abs(off)));
    }
  }
  CHECK(hits > 10'000);
  within(7, named<Real>("height of reprojected points / ulp(1000)"), worst / ulp, 4);
}

TEST_CASE_TEMPLATE("row 10: a ray from 10 radii hits a unit sphere at 9, along every axis", Real,
                   float, double) {
  double worst = 0;
  for (int axis = 0; axis < 3; ++axis) {
    for (const Real sign : {Real(-1), Real(1)}) {
      const auto along = [axis](Real x) {
        return axis == 0   ? Vec3<Real>{x, 0, 0}
               : axis == 1 ? Vec3<Real>{0, x, 0}
                           : Vec3<Real>{0, 0, x};
      };
      Real t = 0;
      REQUIRE(
          enters(Ray<Real>(along(10 * sign), along(-sign)), SphereShape<Real>{{0, 0, 0}, 1}, t));
      worst = std::max(worst, std::abs(static_cast<double>(t) - 9));
    }
  }
  within(10, named<Real>("|t - 9|"), worst, 0);
}

TEST_CASE_TEMPLATE("row 11: a ray finds the exit from any depth below the surface", Real, float,
                   double) {
  Dice dice(seeded(11));
  double backward = 0;
  const int most = sizeof(Real) == sizeof(float) ? 23 : 52;
  for (std::uint64_t i = 0; i < trials(20'000); ++i) {
    const SphereShape<Real> sphere{{0, 0, 0}, static_cast<Real>(dice.ten_to(-12, 12))};
    const int k = static_cast<int>(dice.below(static_cast<std::uint64_t>(most) + 1));
    const double depth = k == 0 ? 1 : std::exp2(-k);
    const double r = static_cast<double>(sphere.radius);
    const Ray<Real> ray(vec_cast<Real>(((1 - depth) * r) * dice.direction()),
                        vec_cast<Real>(dice.direction()));
    const Real t = exit_distance(ray, sphere);
    CHECK_UNARY(t >= 0);
    backward = std::max(backward, Exact<Real>(ray, sphere).backward_error(t));
  }
  within(11, named<Real>("backward error of the exit / ulp"), backward, 8);
}

TEST_CASE_TEMPLATE("row 14: no number within the accepted range results in an infinity or NaN",
                   Real, float, double) {
  Dice dice(seeded(14));
  double bad = 0;
  for (std::uint64_t i = 0; i < trials(100'000); ++i) {
    const auto coordinate = [&] {
      return static_cast<Real>(dice.sign() *
                               (dice.one_in(4) ? limits::max_length : dice.ten_to(-18, 15)));
    };
    const double r = dice.one_in(4) ? (dice.one_in(2) ? limits::min_radius : limits::max_length)
                                    : dice.ten_to(-15, 15);
    const SphereShape<Real> sphere{{coordinate(), coordinate(), coordinate()},
                                   static_cast<Real>(r)};
    const Ray<Real> ray({coordinate(), coordinate(), coordinate()},
                        normalize(vec_cast<Real>(dice.direction())));
    Real t = 0;
    const bool hit = enters(ray, sphere, t);
    const bool leaving = dice.one_in(2);
    const Vec3<Real> n = normal_at(ray, sphere, leaving);
    bad += std::isfinite(t) && std::isfinite(exit_distance(ray, sphere)) ? 0 : 1;
    bad += (hit || leaving) && !std::isfinite(n.x + n.y + n.z) ? 1 : 0;
  }
  within(14, named<Real>("numbers that are not finite"), bad, 0);
}

}  // namespace parray::test
