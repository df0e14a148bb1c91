// Rows 30 to 38 of the table of numerical extremes: directions from materials and the camera.
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "cli/check/doctor/extremes.h"
#include "common/scene/settings.h"
#include "tests/support/extremes.h"
#include "tests/support/path_steps.h"
#include "tests/support/rooms.h"
#include "tests/support/sample_materials.h"
#include "tests/support/sphere_cases.h"
#include "tests/support/statistics.h"
#include "tests/support/tracers.h"

namespace parray::test {
namespace {

template <typename Real>
constexpr double ulp = 2 * static_cast<double>(RealTraits<Real>::unit_roundoff);

/// Hundreds of spheres, also one inside another, of all materials without absorption.
Scene white_crowd(Dice& dice) {
  Scene scene;
  scene.sky = {{1, 1, 1}, {1, 1, 1}};
  scene.camera.tan_half_vfov = 0.4;
  scene.materials = {{MaterialType::diffuse, {1, 1, 1}, 0, 1},
                     {MaterialType::metal, {1, 1, 1}, 0, 1},
                     glass(1.5),
                     glass(1 / 1.5),
                     glass(2.4)};
  for (int i = 0; i < 500; ++i) {
    const Vec3d center = dice.in_cube(6);
    scene.spheres.push_back({center, dice.ten_to(-3, 0), dice.below32(5)});
  }
  return scene;
}

/// Returns whether a ray that meets a glass ball at `cosine` reaches the sky within `depth`
/// segments, by the tracer's own steps.
bool through_glass(double cosine, std::uint32_t depth, std::uint32_t sample) {
  Scene ball;
  ball.materials = {glass(1.5)};
  ball.spheres = {{{0, 0, 0}, 1, 0}};
  RenderSettings settings;
  settings.max_depth = depth;
  static TracedPicture<double> scene = reference_scene<double, double>(ball, settings);
  static const Linear<double> linear(scene.spheres);
  scene.max_depth = depth;
  Ray<double> ray({std::sqrt(1 - cosine * cosine), 0, 3}, {0, 0, -1});
  InsideStack<double> sides;
  sides.start();
  return follow(scene, linear, ray, sides, SampleRandom(seeded(33), depth, sample),
                [](const auto&, const auto&, const auto&) {});
}

/// Returns sine^2 of refraction in exact arithmetic, from the arguments of scatter_dielectric().
template <typename Real>
Quad exact_sine_squared(const MaterialParameters<Real>& surface, bool leaving, const Vec3<Real>& in,
                        const Vec3<Real>& m) {
  const Quad eta = static_cast<Quad>(leaving ? surface.ior : surface.inverse_ior);
  const Quad cosine = -dot(exact(in), exact(m));
  return eta * eta * (1 - cosine * cosine);
}

}  // namespace

TEST_CASE("row 30: among 500 spheres of all materials without absorption each sample is 1") {
  Dice dice(seeded(30));
  const Scene scene = white_crowd(dice);
  double dark = 0;
  RenderSettings settings = doctor::sized(20, 20, trials(6), 100'000);
  for (const Precision precision : {Precision::f32, Precision::mixed, Precision::f64}) {
    settings.precision = precision;
    for (const Tracer& tracer : tracers()) {
      const ReferenceSums sums = tracer.sums(scene, settings);
      dark += static_cast<double>(doctor::pixels_other_than(sums.pixels, std::uint64_t{1} << 32,
                                                            settings.samples_per_pixel));
    }
  }
  within(30, "pixels of the furnace that are not exactly 1", dark, 0);
}

TEST_CASE_TEMPLATE("row 32: diffuse under a sky a + b y is rho (a + 2/3 b n_y)", Real, float,
                   double) {
  Dice dice(seeded(32));
  double worst = 0;
  const auto samples = static_cast<std::uint32_t>(trials(40'000));
  for (std::uint32_t k = 0; k < 12; ++k) {
    const Vec3<Real> n = normalize(vec_cast<Real>(dice.direction()));
    double sum = 0;
    double squares = 0;
    for (std::uint32_t i = 0; i < samples; ++i) {
      const auto u = SampleRandom(seeded(32), k, i).at<Real>(0, Purpose::scatter);
      const auto y = static_cast<double>(scatter_diffuse(n, u).y);
      sum += y;
      squares += y * y;
    }
    const double mean = sum / samples;
    const double variance = squares / samples - mean * mean;
    worst = std::max(worst,
                     std::abs(z_score(sum, samples, 2.0 / 3 * static_cast<double>(n.y), variance)));
  }
  within(32, named<Real>("diffuse under a graded sky: |z|"), worst, 4);
}

TEST_CASE("row 32: a picture of a grey ball under a graded sky equals the closed form") {
  // A distant eye sees the ball as a disc. The mean of n_y over the disc is 0.
  Scene scene;
  scene.sky = {{0.2, 0.2, 0.2}, {0.8, 0.8, 0.8}};  // 0.5 + 0.3 y
  scene.camera.look_from = {0, 0, 1000};
  scene.camera.tan_half_vfov = 0.0005;
  scene.camera.aperture = 0;
  scene.materials = {{MaterialType::diffuse, {0.5, 0.5, 0.5}, 0, 1}};
  scene.spheres = {{{0, 0, 0}, 1, 0}};
  RenderSettings settings;
  settings.width = 16;
  settings.height = 16;
  settings.max_depth = 2;
  settings.samples_per_pixel = static_cast<std::uint32_t>(trials(1024));
  for (const Precision precision : {Precision::f32, Precision::mixed, Precision::f64}) {
    settings.precision = precision;
    double worst = 0;
    for (const Tracer& tracer : tracers()) {
      const std::vector<double> means = means_of(tracer.sums(scene, settings), scene, settings);
      for (std::uint32_t pixel = 0; pixel < 256; ++pixel) {
        const double n_y =
            (7.5 - pixel / 16) / 16.0;  // the picture shows half a radius on each side
        const double expected = 0.5 * (0.5 + 2.0 / 3 * 0.3 * n_y);
        // 0.5 * 0.3 times the standard deviation of w_y, which is at most 0.55.
        const double error = 0.5 * 0.3 * 0.55 / std::sqrt(settings.samples_per_pixel);
        worst = std::max(worst, std::abs(means[3UL * pixel] - expected) / error);
      }
    }
    within(32, "ball under a graded sky, " + std::string(name_of(precision)) + ": |z|", worst, 5);
  }
}

TEST_CASE("row 33: the radiance of a glass ball at depth D is 1 - (1 - Ro) Ri^(D-2)") {
  const double r0 = 0.04;
  const auto schlick = [r0](double cosine) { return r0 + (1 - r0) * std::pow(1 - cosine, 5); };
  const auto samples = static_cast<std::uint32_t>(trials(10'000));
  double worst = 0;
  for (const double cosine : {0.1, 0.5, 0.9}) {
    const double inner = std::sqrt(1 - (1 - cosine * cosine) / 2.25);
    const double outside = schlick(cosine);
    const double inside = schlick(inner);
    for (std::uint32_t depth = 2; depth <= 8; ++depth) {
      double sum = 0;
      for (std::uint32_t i = 0; i < samples; ++i) sum += through_glass(cosine, depth, i) ? 1 : 0;
      const double expected = 1 - (1 - outside) * std::pow(inside, depth - 2);
      const double variance = std::max(expected * (1 - expected), 1.0 / samples);
      worst = std::max(worst, std::abs(z_score(sum, samples, expected, variance)));
    }
  }
  within(33, "glass ball of limited depth: |z|", worst, 4.5);
}

TEST_CASE_TEMPLATE(
    "row 34: total reflection is decided exactly outside 4 ulp of the critical angle", Real, float,
    double) {
  Dice dice(seeded(34));
  const Real top = Real(1) - RealTraits<Real>::unit_roundoff;
  const std::array<Real, 9> iors{Real(1),    Real(1) + Real(ulp<Real>),
                                 top,        Real(1e-3),
                                 Real(1e3),  Real(1.5),
                                 Real(2.4),  Real(1 / 1.5),
                                 Real(1.333)};
  double band = 0;
  double unit = 0;
  double bad = 0;
  int passed = 0;
  for (std::uint64_t i = 0; i < trials(60'000); ++i) {
    const Real ior = iors[dice.below(iors.size())];
    const MaterialParameters<Real> surface(glass(static_cast<double>(ior)));
    const bool leaving = dice.one_in(2);
    const double eta = leaving ? static_cast<double>(ior) : 1 / static_cast<double>(ior);
    const Vec3<Real> m = normalize(vec_cast<Real>(dice.direction()));
    const Vec3d axis = normalize(vec_cast<double>(m));
    const double k = dice.between(-64, 64) * ulp<Real>;
    const double sine = dice.one_in(3) ? dice.unit() : std::min((1 + k) / eta, 1.0);
    const Vec3<Real> in =
        normalize(vec_cast<Real>(sine * dice.across(axis) - std::sqrt(1 - sine * sine) * axis));
    // u = 1 picks refraction unless reflection is total.
    const auto out = scatter_dielectric<Real, bool>(surface, in, m, leaving, {Real(1), 0, 0, 0});
    const Quad square = exact_sine_squared(surface, leaving, in, m);
    const bool refracts = square <= 1;
    passed += refracts ? 1 : 0;
    if (out.mask != refracts) {
      // The unit is an ulp of the angle's cosine and of its product with eta.
      const double scale = ulp<Real> * std::max(1.0, eta * eta);
      band = std::max(band, static_cast<double>(quad_abs(square - 1)) / scale);
    }
    unit = std::max(unit, unit_error(out.direction));
    bad += std::isfinite(out.direction.x + out.direction.y + out.direction.z) ? 0 : 1;
  }
  CHECK(passed > 10'000);
  within(34, named<Real>("wrong total reflection: distance from critical / ulp"), band, 8);
  within(34, named<Real>("length of what glass scatters / ulp"), unit, 4);
  within(34, named<Real>("directions that are not finite"), bad, 0);
}

TEST_CASE_TEMPLATE("row 34: refraction equals that of exact arithmetic", Real, float, double) {
  Dice dice(seeded(35));
  double worst = 0;
  for (std::uint64_t i = 0; i < trials(30'000); ++i) {
    const Material material = glass(dice.one_in(2) ? dice.between(1, 2.5) : dice.between(0.4, 1));
    MaterialParameters<Real> surface(material);
    const bool leaving = dice.one_in(2);
    const Vec3<Real> m = normalize(vec_cast<Real>(dice.direction()));
    const Vec3<Real> in = normalize(vec_cast<Real>(dice.direction()));
    if (dot(in, m) > Real(-0.05)) continue;
    const auto got = scatter_dielectric<Real, bool>(surface, in, m, leaving, {Real(1), 0, 0, 0});
    // The oracle uses another formula: Snell's law along and across the normal.
    const Quad eta = static_cast<Quad>(leaving ? surface.ior : surface.inverse_ior);
    const QuadVec n = (1 / quad_length(exact(m))) * exact(m);
    const QuadVec d = (1 / quad_length(exact(in))) * exact(in);
    const QuadVec across = eta * (d - dot(d, n) * n);
    const Quad rest = 1 - dot(across, across);
    if (got.mask && rest > Quad(0.01)) {
      const QuadVec expected = across - quad_sqrt(rest) * n;
      worst = std::max(
          worst, static_cast<double>(quad_length(exact(got.direction) - expected)) / ulp<Real>);
    }
  }
  within(34, named<Real>("refracted direction / ulp, cosine > 0.1"), worst, 64);
}

TEST_CASE_TEMPLATE(
    "row 36: a diffuse direction is a finite unit vector above the surface for any normal", Real,
    float, double) {
  Dice dice(seeded(36));
  double below = 0;
  double unit = 0;
  for (std::uint64_t i = 0; i < trials(60'000); ++i) {
    const auto u = SampleRandom(seeded(36), static_cast<std::uint32_t>(i), 0)
                       .template at<Real>(0, Purpose::scatter);
    const Vec3<Real> added = uniform_direction(u.a, u.b);
    const double off = dice.one_in(8) ? 0 : dice.ten_to(-17, -6);
    const Vec3<Real> m = normalize(vec_cast<Real>(off * dice.direction()) - added);
    const Vec3<Real> out = scatter_diffuse(m, u);
    below += dot(out, m) > 0 ? 0 : 1;
    unit = std::max(unit, unit_error(out));
  }
  within(36, named<Real>("diffuse directions below their surface"), below, 0);
  within(36, named<Real>("their length / ulp"), unit, 4);
}

TEST_CASE_TEMPLATE(
    "row 37: a path between mirrors keeps its unit length always, and its direction for 20 bounces",
    Real, float, double) {
  Scene walls;
  walls.materials = {{MaterialType::metal, {1, 1, 1}, 0, 1}};
  walls.spheres = {{{0, 0, 0}, 1, 0}};
  RenderSettings settings;
  settings.max_depth = static_cast<std::uint32_t>(trials(100'000));
  const TracedPicture<Real> scene = reference_scene<Real, Real>(walls, settings);
  TracedPicture<Quad> exact_scene = reference_scene<Quad, Real>(walls, settings);
  exact_scene.max_depth = 20;
  const Linear<Real> linear(scene.spheres);
  const Linear<Quad> exact_linear(exact_scene.spheres);
  Dice dice(seeded(37));
  double unit = 0;
  double apart = 0;
  for (int i = 0; i < 5; ++i) {
    const Vec3<Real> from = vec_cast<Real>(dice.between(0, 0.9) * dice.direction());
    const Vec3<Real> way = normalize(vec_cast<Real>(dice.direction()));
    const SampleRandom random(1, 2, 3);
    std::vector<Vec3<Real>> first;
    Ray<Real> ray(from, way);
    InsideStack<Real> sides;
    sides.start();
    sides.cross(0, false);
    follow(scene, linear, ray, sides, random, [&](const auto&, const auto&, const auto& out) {
      unit = std::max(unit, unit_error(out.direction));
      if (first.size() < 20) first.push_back(out.direction);
    });
    Ray<Quad> exactly(exact(from), exact(way));
    InsideStack<Quad> exact_sides;
    exact_sides.start();
    exact_sides.cross(0, false);
    std::size_t k = 0;
    follow(exact_scene, exact_linear, exactly, exact_sides, random,
           [&](const auto&, const auto&, const auto& out) {
             const Quad off = quad_length(exact(first[k]) - out.direction);
             ++k;
             apart =
                 std::max(apart, static_cast<double>(off) / ulp<Real> / static_cast<double>(k * k));
           });
  }
  within(37, named<Real>("length of a mirrored direction, 100 000 bounces / ulp"), unit, 4);
  within(37, named<Real>("off the exact way after k bounces / (k^2 ulp)"), apart, 16);
}

TEST_CASE_TEMPLATE("row 38: rays of extreme cameras have the directions of exact arithmetic", Real,
                   float, double) {
  Dice dice(seeded(38));
  double worst = 0;
  double unit = 0;
  double moved = 0;
  double outside = 0;
  for (const double vfov : {1e-6, 1e-4, 1.0, 90.0, 179.0, 179.99}) {
    for (int i = 0; i < 40; ++i) {
      Camera camera;
      camera.look_from = dice.ten_to(-6, 12) * dice.direction();
      camera.look_at = camera.look_from + dice.ten_to(-3, 12) * dice.direction();
      camera.up = dice.ten_to(-6, 6) * dice.direction();
      camera.tan_half_vfov = std::tan(vfov / 2 * std::acos(-1.0) / 180);
      camera.aperture = i % 2 == 0 ? 0 : dice.ten_to(-6, 6);
      camera.focus_distance = dice.ten_to(-6, 12);
      const auto [width, height] = std::array<std::array<std::uint32_t, 2>, 4>{
          {{1, 1}, {1, 4096}, {65536, 1}, {1200, 800}}}[dice.below(4)];
      const CameraRays<Real> view(camera, width, height);
      const std::uint32_t x = dice.below32(width);
      const std::uint32_t y = dice.below32(height);
      const SampleRandom random(seeded(38), y * width + x, 7);
      const Ray<Real> ray = view.template ray<Real>(x, y, random);
      unit = std::max(unit, unit_error(ray.direction));
      moved += camera.aperture == 0 && !(ray.origin == vec_cast<Real>(camera.look_from)) ? 1 : 0;
      if (camera.aperture > 0) {
        const QuadVec off = exact(ray.origin) - exact(vec_cast<Real>(camera.look_from));
        const double room =
            camera.aperture / 2 * (1 + 8 * ulp<Real>)+length(camera.look_from) * ulp<Real>;
        outside += static_cast<double>(quad_length(off)) <= room ? 0 : 1;
        continue;
      }
      // The oracle computes its own basis with 113 bits.
      const QuadVec back = exact(camera.look_from) - exact(camera.look_at);
      const QuadVec w = (1 / quad_length(back)) * back;
      const QuadVec side = cross(exact(camera.up), w);
      const QuadVec right = (1 / quad_length(side)) * side;
      const QuadVec up = cross(w, right);
      const auto u = random.at<Quad>(0, Purpose::camera);
      const Quad half = camera.tan_half_vfov;
      const Quad a = half * static_cast<Quad>(width) / static_cast<Quad>(height) *
                     (2 * (static_cast<Quad>(x) + u.a) / static_cast<Quad>(width) - 1);
      const Quad b = half * (1 - 2 * (static_cast<Quad>(y) + u.b) / static_cast<Quad>(height));
      const QuadVec aim = a * right + b * up - w;
      const QuadVec exact_way = (1 / quad_length(aim)) * aim;
      // Rounding of the coordinates on the film, relative to the ray's length there.
      const Quad film = 1 + half * (1 + static_cast<Quad>(width) / static_cast<Quad>(height));
      // If `up` is nearly parallel to the view, the basis is ill-conditioned; the tracer is not to
      // blame.
      const Quad sine = quad_length(side) / quad_length(exact(camera.up));
      const Quad scale = film / quad_length(aim) / (sizeof(Real) == 8 ? sine : Quad(1)) +
                         static_cast<Quad>(sizeof(Real) == 8 ? 1 : 0) *
                             quad_length(exact(camera.look_from)) / quad_length(back) / sine;
      worst = std::max(
          worst,
          static_cast<double>(quad_length(exact(ray.direction) - exact_way) / scale) / ulp<Real>);
    }
  }
  within(38, named<Real>("ray direction / ulp of the film's extent"), worst, 8);
  within(38, named<Real>("its length / ulp"), unit, 4);
  within(38, named<Real>("rays that begin outside the lens"), outside, 0);
  within(38, named<Real>("pinhole rays from elsewhere"), moved, 0);
}

}  // namespace parray::test
