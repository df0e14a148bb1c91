#include "common/trace/integrator/material.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

#include "tests/support/dice.h"
#include "tests/support/rooms.h"
#include "tests/support/sample_materials.h"
#include "tests/support/statistics.h"

namespace parray {
namespace {

using test::Dice;
using test::glass;
using test::metal;
using test::z_limit;
using test::z_score;

template <typename Real>
constexpr Real ulp = 2 * RealTraits<Real>::unit_roundoff;

/// A ray that meets the surface with normal `m` at this cosine.
template <typename Real>
Vec3<Real> incoming_at(const Vec3<Real>& m, double cosine, Dice& dice) {
  const Vec3d normal = vec_cast<double>(m);
  const Vec3d along = dice.across(normalize(normal));
  return normalize(vec_cast<Real>(std::sqrt(1 - cosine * cosine) * along + (-cosine) * normal));
}

template <typename Real>
Vec3<Real> random_normal(Dice& dice) {
  return normalize(vec_cast<Real>(dice.direction()));
}

template <typename Real>
bool is_unit(const Vec3<Real>& v) {
  return std::abs(length(v) - 1) <= 4 * ulp<Real>;
}

/// How far three unit vectors are from lying in one plane.
template <typename Real>
Real out_of_plane(const Vec3<Real>& a, const Vec3<Real>& b, const Vec3<Real>& c) {
  return std::abs(dot(cross(a, b), c));
}

}  // namespace

TEST_CASE_TEMPLATE("a mirror reflects at the angle of incidence, in the plane of incidence", Real,
                   float, double) {
  Dice dice(1);
  const MaterialParameters<Real> surface(metal(0));
  for (int i = 0; i < 20'000; ++i) {
    const Vec3<Real> m = random_normal<Real>(dice);
    const Vec3<Real> in = incoming_at(m, dice.between(0, 1), dice);
    const auto out = scatter(surface, in, m, false, SampleRandom(1, 2, 3), 0);
    CHECK_UNARY(out.event == Event::reflected);
    CHECK_UNARY(is_unit(out.direction));
    CHECK_UNARY(std::abs(dot(out.direction, m) + dot(in, m)) <= 8 * ulp<Real>);
    CHECK_UNARY(out_of_plane(in, m, out.direction) <= 8 * ulp<Real>);
    CHECK_UNARY(std::abs(dot(out.direction - in, cross(m, in))) <= 8 * ulp<Real>);
  }
  const auto back = scatter<Real>(surface, {0, -1, 0}, {0, 1, 0}, false, SampleRandom(1, 2, 3), 0);
  CHECK(back.direction == Vec3<Real>{0, 1, 0});
}

TEST_CASE("fuzz absorbs 1 - f^2 / 10 of a wide beam on a white ball less than a mirror does") {
  // The reflected direction plus a point of a ball of radius f ends below the surface: over the
  // disc that a distant sphere shows, for a share of f^2 / 10.
  for (const double fuzz : {0.3, 0.7, 1.0}) {
    const MaterialParameters<float> surface(metal(fuzz));
    Dice dice(2);
    constexpr int count = 300'000;
    double absorbed = 0;
    for (int i = 0; i < count; ++i) {
      const double cosine = std::sqrt(dice.unit());
      const Vec3<float> in{static_cast<float>(std::sqrt(1 - cosine * cosine)),
                           static_cast<float>(-cosine), 0};
      const SampleRandom random(3, static_cast<std::uint32_t>(i), 0);
      const auto out = scatter<float>(surface, in, {0, 1, 0}, false, random, 1);
      absorbed += out.event == Event::absorbed ? 1 : 0;
      if (out.event != Event::absorbed) {
        CHECK_UNARY(out.direction.y > 0);
        CHECK_UNARY(is_unit(out.direction));
      }
    }
    const double share = fuzz * fuzz / 10;
    CHECK(std::abs(z_score(absorbed, count, share, share * (1 - share))) < z_limit);
  }
}

TEST_CASE("a diffuse surface scatters as Lambert says: the squared cosine is uniform") {
  constexpr std::size_t side = 24;
  std::vector<double> cells(side * side);
  const MaterialParameters<float> surface(Material{});
  for (std::uint32_t i = 0; i < 400'000; ++i) {
    const auto out =
        scatter<float>(surface, {0.6F, -0.8F, 0}, {0, 1, 0}, false, SampleRandom(4, i, 0), 0);
    const Vec3d w = vec_cast<double>(out.direction);
    CHECK_UNARY((out.event == Event::reflected && w.y > 0 && is_unit(out.direction)));
    const double turns = std::atan2(w.z, w.x) / (2 * 3.14159265358979323846) + 0.5;
    cells[test::bin_of(w.y * w.y, side) * side + test::bin_of(turns, side)] += 1;
  }
  CHECK(std::abs(test::chi_square_z(cells)) < z_limit);
}

TEST_CASE_TEMPLATE("a diffuse direction next to the surface's own plane is unit and above it", Real,
                   float, double) {
  Dice dice(5);
  for (std::uint32_t i = 0; i < 50'000; ++i) {
    const Uniform4<Real> u = SampleRandom(6, i, 0).at<Real>(0, Purpose::scatter);
    // The normal opposite to the direction that is added to it, but for some roundings.
    const Vec3<Real> added = uniform_direction(u.a, u.b);
    const double off = dice.one_in(4) ? 0 : dice.ten_to(-17, -3);
    const Vec3<Real> m = normalize(vec_cast<Real>(off * dice.direction()) - added);
    const Vec3<Real> out = scatter_diffuse(m, u);
    CHECK_UNARY(is_unit(out));
    CHECK_UNARY(dot(out, m) > 0);
  }
}

TEST_CASE_TEMPLATE("glass refracts as Snell says, in the plane of incidence", Real, float, double) {
  Dice dice(7);
  int refracted = 0;
  for (int i = 0; i < 40'000; ++i) {
    const double ior = dice.one_in(2) ? dice.between(1, 2.5) : dice.between(0.4, 1);
    const MaterialParameters<Real> surface(glass(ior));
    const bool leaving = dice.one_in(2);
    const double eta = leaving ? ior : 1 / ior;  // of the side it comes from over the other
    const Vec3<Real> m = random_normal<Real>(dice);
    const Vec3<Real> in = incoming_at(m, dice.between(0.02, 1), dice);
    const auto out =
        scatter(surface, in, m, leaving, SampleRandom(8, 1, dice.below32(1U << 30)), 0);
    CHECK_UNARY(is_unit(out.direction));
    CHECK_UNARY(out.event != Event::absorbed);
    if (out.event == Event::refracted) {
      ++refracted;
      const double sine_in = static_cast<double>(length(cross(in, m)));
      const double sine_out = static_cast<double>(length(cross(out.direction, m)));
      CHECK_UNARY(std::abs(sine_out - eta * sine_in) <= 16 * static_cast<double>(ulp<Real>));
      CHECK_UNARY(dot(out.direction, m) <= 0);
      CHECK_UNARY(out_of_plane(in, m, out.direction) <= 16 * ulp<Real>);
      CHECK_UNARY(dot(cross(in, m), cross(out.direction, m)) >= -16 * ulp<Real>);  // no turn back
    } else {
      CHECK_UNARY(std::abs(dot(out.direction, m) + dot(in, m)) <= 8 * ulp<Real>);
    }
  }
  CHECK(refracted > 20'000);
}

TEST_CASE_TEMPLATE("beyond the critical angle all is reflected, within it never for sure", Real,
                   float, double) {
  const MaterialParameters<Real> surface(glass(1.5));
  const double critical = std::sqrt(1 - 1 / (1.5 * 1.5));  // cosine, seen from inside
  Dice dice(9);
  for (int k = 1; k <= 60; ++k) {
    const double away = std::ldexp(1.0, -k);
    if (away < 16 * static_cast<double>(ulp<Real>)) break;
    int passed_within = 0;
    for (std::uint32_t i = 0; i < 200; ++i) {
      const SampleRandom random(10, i, static_cast<std::uint32_t>(k));
      const Vec3<Real> m = random_normal<Real>(dice);
      const auto beyond =
          scatter(surface, incoming_at(m, critical * (1 - away), dice), m, true, random, 0);
      CHECK_UNARY(beyond.event == Event::reflected);
      const double within = std::min(critical * (1 + away), 1.0);
      const auto inside = scatter(surface, incoming_at(m, within, dice), m, true, random, 0);
      passed_within += inside.event == Event::refracted ? 1 : 0;
      CHECK_UNARY(is_unit(inside.direction));
    }
    CHECK(passed_within > 0);
  }
}

TEST_CASE("glass reflects with Schlick's probability, at every angle and from both sides") {
  for (const double ior : {1.0, 1.5, 2.4, 1 / 1.5}) {
    const MaterialParameters<double> surface(glass(ior));
    const double r0 = std::pow((1 - ior) / (1 + ior), 2);
    for (const double cosine : {1.0, 0.9, 0.5, 0.1}) {
      for (const bool leaving : {false, true}) {
        const double eta = leaving ? ior : 1 / ior;
        const bool total = eta * eta * (1 - cosine * cosine) > 1;
        const double expected = total ? 1 : r0 + (1 - r0) * std::pow(1 - cosine, 5);
        constexpr std::uint32_t count = 20'000;
        double reflected = 0;
        for (std::uint32_t i = 0; i < count; ++i) {
          const auto out = scatter<double>(surface, {std::sqrt(1 - cosine * cosine), -cosine, 0},
                                           {0, 1, 0}, leaving, SampleRandom(11, i, 0), 0);
          reflected += out.event == Event::reflected ? 1 : 0;
        }
        CAPTURE(ior);
        CAPTURE(cosine);
        CAPTURE(leaving);
        const double variance = std::max(expected * (1 - expected), 1e-9);
        CHECK(std::abs(z_score(reflected, count, expected, variance)) < z_limit);
      }
    }
  }
}

TEST_CASE_TEMPLATE("glass of index 1 lets rays pass straight on", Real, float, double) {
  Dice dice(12);
  const MaterialParameters<Real> surface(glass(1));
  for (std::uint32_t i = 0; i < 2000; ++i) {
    const Vec3<Real> m = random_normal<Real>(dice);
    const Vec3<Real> in = incoming_at(m, dice.between(0.2, 1), dice);
    const auto out = scatter(surface, in, m, dice.one_in(2), SampleRandom(13, i, 0), 0);
    if (out.event == Event::refracted) CHECK_UNARY(length(out.direction - in) <= 32 * ulp<Real>);
  }
}

TEST_CASE("a scattering event is a function of seed, pixel, sample and bounce") {
  const MaterialParameters<double> surface(metal(0.5));
  const Vec3d in{0.6, -0.8, 0};
  const Vec3d m{0, 1, 0};
  const auto direction = [&](std::uint64_t seed, std::uint32_t pixel, std::uint32_t sample,
                             std::uint32_t bounce) {
    return scatter(surface, in, m, false, SampleRandom(seed, pixel, sample), bounce).direction;
  };
  const Vec3d here = direction(1, 2, 3, 4);
  CHECK(direction(1, 2, 3, 4) == here);
  CHECK_FALSE(direction(2, 2, 3, 4) == here);
  CHECK_FALSE(direction(1, 3, 3, 4) == here);
  CHECK_FALSE(direction(1, 2, 4, 4) == here);
  CHECK_FALSE(direction(1, 2, 3, 5) == here);
}

}  // namespace parray
