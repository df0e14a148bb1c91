#include "common/trace/sphere.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "common/scene/limits.h"
#include "tests/support/dice.h"
#include "tests/support/rooms.h"
#include "tests/support/sphere_cases.h"

namespace parray {
namespace {

using test::Dice;
using test::Exact;
using test::exact;
using test::Quad;
using test::quad_abs;
using test::quad_length;
using test::quad_sqrt;
using test::QuadVec;

/// random_case() over twelve decades of radius.
template <typename Real>
test::SphereCase<Real> random_case(Dice& dice, double impact, double nearest, double farthest) {
  return test::sphere_case<Real>(dice, 6, impact, nearest, farthest);
}

struct Worst : test::WorstEntry {
  void check() const {
    CHECK(backward <= 8);
    CHECK(forward <= 8);
    CHECK(normal <= 8);
    CHECK(unit <= 2);
    CHECK(band <= 2);
  }
};

/// The discriminant of school books: what these tests must be able to reject.
template <typename Real>
bool textbook_enters(const Ray<Real>& ray, const SphereShape<Real>& sphere, Real& t) {
  const Vec3<Real> f = ray.origin - sphere.center;
  const Real half_b = dot(f, ray.direction);
  const Real a = dot(ray.direction, ray.direction);
  const Real d = half_b * half_b - a * (dot(f, f) - sphere.radius * sphere.radius);
  t = (-half_b - std::sqrt(std::max(d, Real(0)))) / a;
  return d >= 0 && half_b < 0;
}

template <typename Real>
Real ulps(Real value, int steps) {
  for (int i = 0; i < std::abs(steps); ++i) {
    value = std::nextafter(value, steps > 0 ? Real(2) * value : Real(0));
  }
  return value;
}

}  // namespace

TEST_CASE_TEMPLATE("entry errs by 8 ulp(S) at most over 12 decades of radius and distance", Real,
                   float, double) {
  Dice dice(1);
  Worst worst;
  for (int i = 0; i < 60'000; ++i) {
    worst.look_at(random_case<Real>(dice, dice.between(0, 1.1), 1.0001, 1e7));
  }
  worst.check();
  CHECK(worst.hits > 45'000);
  CHECK(worst.misses > 5'000);
}

TEST_CASE_TEMPLATE("entry errs by 8 ulp(S) at most close to the surface", Real, float, double) {
  Dice dice(2);
  Worst worst;
  for (int i = 0; i < 30'000; ++i) {
    worst.look_at(random_case<Real>(dice, dice.between(0, 1.1), 1.0001, 1.1));
  }
  worst.check();
}

TEST_CASE_TEMPLATE("grazing rays are misjudged within 2 ulp(S) of tangency only", Real, float,
                   double) {
  Dice dice(3);
  Worst worst;
  for (int i = 0; i < 60'000; ++i) {
    const double away = dice.sign() * dice.ten_to(-15, -3);
    worst.look_at(random_case<Real>(dice, 1 + away, 1.01, 1e5));
  }
  worst.check();
  CHECK(worst.hits > 15'000);
  CHECK(worst.misses > 15'000);
}

TEST_CASE("the oracle rejects the textbook discriminant") {
  Dice dice(4);
  double backward = 0;
  int wrong = 0;
  for (int i = 0; i < 5'000; ++i) {
    const auto c = random_case<float>(dice, dice.between(0, 0.9), 10, 1e5);
    const Exact<float> truth(c.ray, c.sphere);
    float t = 0;
    const bool hit = textbook_enters(c.ray, c.sphere, t);
    wrong += hit != truth.enters() && truth.tangency() > 2 ? 1 : 0;
    backward = std::max(backward, hit ? truth.backward_error(t) : 0);
  }
  CHECK(backward > 1000);
  CHECK(wrong > 100);
}

TEST_CASE_TEMPLATE("a ray from inside leaves at the far crossing, to 8 ulp", Real, float, double) {
  Dice dice(5);
  double backward = 0;
  double normal = 0;
  for (int i = 0; i < 40'000; ++i) {
    const double r = dice.ten_to(-6, 6);
    const SphereShape<Real> sphere{vec_cast<Real>((dice.one_in(2) ? 0 : r) * dice.direction()),
                                   static_cast<Real>(r)};
    // At the centre, anywhere, and ever nearer to the surface.
    const double depth = i % 3 == 0   ? 1
                         : i % 3 == 1 ? dice.unit()
                                      : std::exp2(-dice.between(1, 20));
    const Vec3<Real> origin =
        vec_cast<Real>(vec_cast<double>(sphere.center) + ((1 - depth) * r) * dice.direction());
    const Ray<Real> ray(origin, vec_cast<Real>(dice.ten_to(-6, 6) * dice.direction()));
    const Exact<Real> truth(ray, sphere);
    const Real t = exit_distance(ray, sphere);
    CHECK(t >= 0);
    backward = std::max(backward, truth.backward_error(t));
    normal = std::max(
        normal, truth.normal_error(normal_at(ray, sphere, true), truth.foot + truth.half_chord));
  }
  CHECK(backward <= 8);
  CHECK(normal <= 8);
}

TEST_CASE_TEMPLATE("a ray from the surface inward ends on the other end of its chord", Real, float,
                   double) {
  Dice dice(6);
  double surface = 0;
  double forward = 0;
  for (int i = 0; i < 40'000; ++i) {
    const auto radius = static_cast<Real>(dice.ten_to(-6, 6));
    const SphereShape<Real> sphere{vec_cast<Real>(dice.direction()), radius};
    const Vec3<Real> n = normalize(vec_cast<Real>(dice.direction()));
    const Vec3d into = dice.one_in(3) ? vec_cast<double>(n) + dice.ten_to(-6, -1) * dice.direction()
                                      : dice.direction();
    const Ray<Real> ray(sphere.center + radius * n, vec_cast<Real>(into));
    const Real t = chord_from_surface(ray, sphere, n);
    const Quad slope = dot(exact(n), exact(ray.direction));
    const Quad square = dot(exact(ray.direction), exact(ray.direction));
    const Quad chord = slope < 0 ? -2 * static_cast<Quad>(radius) * slope / square : Quad(0);
    const Quad ulp = 2 * static_cast<Quad>(RealTraits<Real>::unit_roundoff);
    const Quad error = quad_abs(static_cast<Quad>(t) - chord) * quad_sqrt(square) / radius;
    forward = std::max(forward, static_cast<double>(error / ulp));
    // From the unit normal itself: the centre and its rounding do not come in.
    const QuadVec end = exact(n) + (static_cast<Quad>(t) / radius) * exact(ray.direction);
    const Quad off = quad_abs(quad_length(end) - 1);
    surface = std::max(surface, static_cast<double>(slope < 0 ? off / ulp : Quad(0)));
  }
  CHECK(forward <= 8);
  CHECK(surface <= 8);
}

TEST_CASE_TEMPLATE("a chord along the surface or outward has length 0", Real, float, double) {
  const SphereShape<Real> sphere{{0, 0, 0}, 2};
  const Vec3<Real> n{0, 1, 0};
  CHECK(chord_from_surface(Ray<Real>({0, 2, 0}, {1, 0, 0}), sphere, n) == 0);
  CHECK(chord_from_surface(Ray<Real>({0, 2, 0}, {1, 1, 0}), sphere, n) == 0);
  CHECK(chord_from_surface(Ray<Real>({0, 2, 0}, {0, -1, 0}), sphere, n) == 4);
}

TEST_CASE_TEMPLATE("a tangent ray hits at its foot at every scale and along every axis", Real,
                   float, double) {
  const auto turned = [](int axis, Real a, Real b) {
    return axis == 0 ? Vec3<Real>{a, b, 0} : axis == 1 ? Vec3<Real>{0, a, b} : Vec3<Real>{b, 0, a};
  };
  for (int k = -40; k <= 40; ++k) {
    const Real s = std::ldexp(Real(1), k);
    for (int axis = 0; axis < 3; ++axis) {
      const SphereShape<Real> sphere{{0, 0, 0}, s};
      Real t = -1;
      CHECK(enters(Ray<Real>(turned(axis, -5 * s, s), turned(axis, 1, 0)), sphere, t));
      CHECK(t == 5 * s);
      CHECK(enters(Ray<Real>(turned(axis, -5 * s, ulps(s, -1)), turned(axis, 1, 0)), sphere, t));
      CHECK(t <= 5 * s);
      CHECK_FALSE(
          enters(Ray<Real>(turned(axis, -5 * s, ulps(s, 1)), turned(axis, 1, 0)), sphere, t));
    }
  }
}

TEST_CASE_TEMPLATE("the vectors of Lass are met", Real, float, double) {
  // cocamware/lass, test_prim_ray_3d_sphere_3d: a small sphere far away and a large one close by.
  const Vec3<Real> center{Real(-0x1.de5af8p9), Real(-0x1.ca3b2p8), Real(0x1.538914p9)};
  const Ray<Real> ray({Real(0x1.fbc35p9), Real(0x1.edfdcp9), Real(0x1.828c6p6)},
                      {Real(-0x1.91530cp-1), Real(-0x1.26e484p-1), Real(0x1.db5422p-3)});
  const std::array<std::array<double, 3>, 2> table{
      {{0x1.e8b828p1, 0x1.39e9856062562p11, 0x1.3a99fd4c44718p11},
       {0x1.38b828p11, 0x1.89a5cc662338bp3, 0x1.397cee7020523p12}}};
  for (const auto& [radius, entry, exit] : table) {
    const SphereShape<Real> sphere{center, static_cast<Real>(radius)};
    const Exact<Real> truth(ray, sphere);
    CHECK(static_cast<double>(truth.foot - truth.half_chord) ==
          doctest::Approx(entry).epsilon(1e-14));
    CHECK(static_cast<double>(truth.foot + truth.half_chord) ==
          doctest::Approx(exit).epsilon(1e-14));
    for (const Real scale : {Real(1), Real(2)}) {
      const Ray<Real> scaled(ray.origin, scale * ray.direction);
      Real t = 0;
      REQUIRE(enters(scaled, sphere, t));
      CHECK(truth.forward_error(scale * t, static_cast<Quad>(entry)) <= 2);
      CHECK(truth.forward_error(scale * exit_distance(scaled, sphere), static_cast<Quad>(exit)) <=
            2);
    }
  }
}

TEST_CASE_TEMPLATE("distances scale exactly with the inverse length of the direction", Real, float,
                   double) {
  Dice dice(7);
  const int most = sizeof(Real) == sizeof(float) ? 40 : 300;
  for (int i = 0; i < 4'000; ++i) {
    const auto c = random_case<Real>(dice, dice.between(0, 1.05), 1.0001, 1e3);
    const int k = static_cast<int>(dice.below(2 * static_cast<std::uint64_t>(most) + 1)) - most;
    const Real power = std::ldexp(Real(1), k);
    const Vec3<Real> direction = normalize(c.ray.direction);
    const Ray<Real> one(c.ray.origin, direction);
    const Ray<Real> other(c.ray.origin, power * direction);
    Real t = -1;
    Real u = -1;
    CHECK(enters(one, c.sphere, t) == enters(other, c.sphere, u));
    CHECK((t == -1 ? u == -1 : u == t / power));
    CHECK(exit_distance(other, c.sphere) == exit_distance(one, c.sphere) / power);
  }
}

TEST_CASE_TEMPLATE("a ray that leaves one sphere for another that touches it never goes back", Real,
                   float, double) {
  Dice dice(8);
  int entered = 0;
  double forward = 0;
  for (int i = 0; i < 40'000; ++i) {
    const auto big = static_cast<Real>(dice.ten_to(-3, 3));
    const auto small = static_cast<Real>(dice.ten_to(-3, 0)) * big;
    const Vec3<Real> n = normalize(vec_cast<Real>(dice.direction()));
    const SphereShape<Real> from{vec_cast<Real>(dice.direction()), big};
    // Touching but for a few roundings: a gap or an overlap.
    const SphereShape<Real> to{from.center + (big + small) * n, small};
    const Vec3<Real> origin = from.center + big * n;
    Vec3<Real> way = vec_cast<Real>(dice.direction());
    way = dot(way, n) < 0 ? -way : way;
    const Ray<Real> ray(origin, way);
    Real t = -1;
    if (enters(ray, to, t)) {
      ++entered;
      CHECK(t >= 0);
      CHECK(std::isfinite(t));
      const Exact<Real> truth(ray, to);
      const Quad root = truth.foot - truth.half_chord;  // < 0 in an overlap
      forward = std::max(forward, truth.forward_error(t, root > 0 ? root : Quad(0)));
    }
  }
  CHECK(entered > 20'000);
  CHECK(forward <= 8);  // met at the contact, not on the other side
}

TEST_CASE_TEMPLATE("a sphere behind the origin or around a direction away is not entered", Real,
                   float, double) {
  const SphereShape<Real> sphere{{0, 0, 0}, 1};
  Real t = 0;
  CHECK_FALSE(enters(Ray<Real>({2, 0, 0}, {1, 0, 0}), sphere, t));
  CHECK_FALSE(enters(Ray<Real>({1, 0, 0}, {0, 1, 0}), sphere, t));  // along the tangent plane
  CHECK(enters(Ray<Real>({2, 0, 0}, {-1, 0, 0}), sphere, t));
  CHECK(t == 1);
}

TEST_CASE_TEMPLATE("nothing overflows at the limits of coordinates and radii", Real, float,
                   double) {
  for (const double r : {limits::min_radius, 1.0, limits::max_length}) {
    for (const double x : {0.0, limits::max_length}) {
      const SphereShape<Real> sphere{{static_cast<Real>(x), 0, 0}, static_cast<Real>(r)};
      const Ray<Real> ray({static_cast<Real>(-limits::max_length), 0, 0}, {1, 0, 0});
      Real t = -1;
      CHECK(enters(ray, sphere, t));
      CHECK(std::isfinite(t));
      CHECK(std::isfinite(exit_distance(ray, sphere)));
      CHECK(normal_at(ray, sphere, false) == Vec3<Real>{-1, 0, 0});
    }
  }
}

TEST_CASE("from the centre of a smallest sphere the normal is the direction") {
  const auto r = static_cast<float>(limits::min_radius);
  const SphereShape<float> sphere{{0, 0, 0}, r};
  const Ray<float> ray({0, 0, 0}, {0, 1, 0});
  CHECK(exit_distance(ray, sphere) == doctest::Approx(r).epsilon(1e-6));
  CHECK(normal_at(ray, sphere, true) == Vec3<float>{0, 1, 0});
}

}  // namespace parray
