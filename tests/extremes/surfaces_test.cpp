// Rows 23 to 29 of the table of numerical extremes: no path hits the surface that it leaves, no
// path leaks, and thin shells keep their order.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "cli/check/doctor/extremes.h"
#include "common/scene/settings.h"
#include "tests/support/extremes.h"
#include "tests/support/path_steps.h"
#include "tests/support/precisions.h"
#include "tests/support/quad.h"
#include "tests/support/rooms.h"
#include "tests/support/sample_materials.h"
#include "tests/support/sphere_cases.h"
#include "tests/support/tracers.h"

namespace parray::test {
namespace {

using doctor::sized;
using doctor::under_white_sky;

double pixels_other_than(const ReferenceSums& sums, std::uint64_t fixed, std::uint64_t samples) {
  return static_cast<double>(doctor::pixels_other_than(sums.pixels, fixed, samples));
}

/// Returns a scene of nested glass shells of one kind, each `gap` inside the previous one.
Scene nested_shells(int count, double gap) {
  Scene scene = under_white_sky();
  scene.camera.look_from = {0, 0.3, 4};
  scene.camera.tan_half_vfov = 0.24;
  scene.materials = {glass(1.5), glass(1 / 1.5)};
  for (int i = 0; i < count; ++i) {
    scene.spheres.push_back({{0, 0, 0}, 1 - i * gap, static_cast<std::uint32_t>(i % 2)});
  }
  return scene;
}

/// Returns a scene of the limb of three nested glass balls. No ray passes further than 1e-7 from
/// it.
Scene limb() {
  Scene scene = nested_shells(3, 0x1p-23);
  scene.camera.look_from = {1, 0, 5};
  scene.camera.look_at = {1, 0, 0};
  scene.camera.tan_half_vfov = 2e-8;
  return scene;
}

/// Returns the share of paths that meet other surfaces than the same path with 113 bits, on the
/// same spheres.
template <typename Real>
double share_of_other_paths(const Scene& scene, const RenderSettings& settings,
                            std::uint64_t paths) {
  const TracedPicture<Real> traced = reference_scene<Real, Real>(scene, settings);
  TracedPicture<Quad> exactly = exact_scene(scene, settings);
  for (std::size_t i = 0; i < scene.spheres.size(); ++i) {
    exactly.spheres[i] = {exact(traced.spheres[i].center), Quad(traced.spheres[i].radius)};
  }
  const Linear<Real> linear(traced.spheres);
  const Linear<Quad> exact_linear(exactly.spheres);
  const std::uint32_t pixels = settings.width * settings.height;
  double other = 0;
  std::size_t steps = 0;
  for (std::uint64_t i = 0; i < paths; ++i) {
    const auto pixel = static_cast<std::uint32_t>(i % pixels);
    const SampleRandom random(seeded(29), pixel, static_cast<std::uint32_t>(i / pixels));
    const std::uint32_t x = pixel % settings.width;
    const std::uint32_t y = pixel / settings.width;
    const std::vector<Step> path = steps_of(traced, linear, x, y, random);
    other += path == steps_of(exactly, exact_linear, x, y, random) ? 0 : 1;
    steps += path.size();
  }
  CHECK(steps > 3 * paths);  // paths really cross shells
  return other / static_cast<double>(paths);
}

/// Linear search that records how far rays start from the surface that they stand on.
template <typename Real>
class HeightSpy {
 public:
  explicit HeightSpy(const std::vector<SphereShape<Real>>& spheres)
      : spheres_(spheres), linear_(spheres) {}

  void enter(const Ray<Real>& ray, const InsideStack<Real>& sides, Hit<Real>& best) const {
    for (std::uint32_t i = 0; i < spheres_.size(); ++i) {
      if (sides.stands_on(i)) {
        const Quad r = spheres_[i].radius;
        const QuadVec from_center = exact(ray.origin) - exact(spheres_[i].center);
        const Quad size = quad_length(exact(spheres_[i].center)) + r;
        const Quad ulp = 2 * static_cast<Quad>(RealTraits<Real>::unit_roundoff) * size;
        worst_ =
            std::max(worst_, static_cast<double>(quad_abs(quad_length(from_center) - r) / ulp));
        ++starts_;
      }
    }
    linear_.enter(ray, sides, best);
  }
  [[nodiscard]] std::size_t bytes() const { return 0; }
  [[nodiscard]] double worst() const { return worst_; }
  [[nodiscard]] int starts() const { return starts_; }

 private:
  std::vector<SphereShape<Real>> spheres_;
  Linear<Real> linear_;
  mutable double worst_ = 0;
  mutable int starts_ = 0;
};

}  // namespace

TEST_CASE_TEMPLATE("rows 7, 12: a path continues exactly from the surface, also from far away",
                   Real, float, double) {
  Dice dice(seeded(12));
  double worst = 0;
  int starts = 0;
  for (int k = 0; k < 40; ++k) {
    const double r = dice.ten_to(-3, 3);
    Scene scene = under_white_sky();
    const double away = r * dice.ten_to(0.5, 6);
    scene.camera.look_from = away * dice.direction();
    scene.camera.tan_half_vfov = 2 * r / away;
    scene.materials = {diffuse(0.5), glass(1.5), {MaterialType::metal, {1, 1, 1}, 0.2, 1}};
    scene.spheres = {{{0, 0, 0}, r, 0},
                     {1.5 * r * dice.direction(), r, 1},
                     {1.2 * r * dice.direction(), 0.3 * r, 2}};
    const RenderSettings settings = sized(8, 8, 1, 30);
    const TracedPicture<Real> traced = reference_scene<Real, Real>(scene, settings);
    const HeightSpy<Real> spy(traced.spheres);
    InsideStack<Real> sides;
    TraceCounts counts;
    for (std::uint32_t i = 0; i < trials(64); ++i) {
      trace_sample(traced, traced, spy, i % 8, i / 8 % 8, SampleRandom(seeded(12), i % 64, i / 64),
                   sides, counts);
    }
    worst = std::max(worst, spy.worst());
    starts += spy.starts();
  }
  CHECK(starts > 1000);
  within(7, named<Real>("where paths go on: off the surface / ulp(|c| + r)"), worst, 4);
}

TEST_CASE_TEMPLATE("row 12: a chord from the surface ends on the other side to 8 ulp", Real, float,
                   double) {
  Dice dice(seeded(13));
  double worst = 0;
  for (std::uint64_t i = 0; i < trials(50'000); ++i) {
    const SphereShape<Real> sphere = any_sphere<Real>(dice, 12);
    const Vec3<Real> n = normalize(vec_cast<Real>(dice.direction()));
    const Ray<Real> ray(sphere.center + sphere.radius * n,
                        vec_cast<Real>(dice.ten_to(-6, 6) * dice.direction()));
    const Quad slope = dot(exact(n), exact(ray.direction));
    const Quad square = dot(exact(ray.direction), exact(ray.direction));
    const Quad chord = slope < 0 ? -2 * Quad(sphere.radius) * slope / square : Quad(0);
    const Quad off = quad_abs(Quad(chord_from_surface(ray, sphere, n)) - chord);
    const Quad ulp = 2 * static_cast<Quad>(RealTraits<Real>::unit_roundoff);
    worst = std::max(worst, static_cast<double>(off * quad_sqrt(square) / sphere.radius / ulp));
  }
  within(12, named<Real>("length of a chord from the surface / ulp"), worst, 8);
}

TEST_CASE_TEMPLATE("row 23: a ray that leaves a convex surface never meets it again", Real, float,
                   double) {
  Dice dice(seeded(23));
  double again = 0;
  double inside_out = 0;
  for (std::uint64_t i = 0; i < trials(1000); ++i) {
    Scene ball = under_white_sky();
    ball.materials = {diffuse(0.5)};
    const double r = dice.ten_to(-4, 4);
    ball.spheres = {{dice.ten_to(-8, 8) * dice.direction(), r, 0}};
    const TracedPicture<Real> scene = reference_scene<Real, Real>(ball, sized(4, 4, 1, 2));
    // As stored, because rebasing would move the centre to 0.
    const SphereShape<Real> sphere{vec_cast<Real>(ball.spheres[0].center), static_cast<Real>(r)};
    TracedPicture<Real> here = scene;
    here.spheres = {sphere};
    const Linear<Real> linear(here.spheres);
    for (int k = 0; k < 200; ++k) {
      const Vec3<Real> n = normalize(vec_cast<Real>(dice.direction()));
      const SampleRandom random(seeded(23), static_cast<std::uint32_t>(i),
                                static_cast<std::uint32_t>(k));
      for (const bool inner : {false, true}) {
        const auto away = scatter(here.surfaces[0], -n, inner ? -n : n, inner, random, 0);
        const Ray<Real> ray(sphere.center + sphere.radius * n, away.direction);
        InsideStack<Real> sides;
        sides.start();
        if (inner) sides.cross(0, false);
        sides.stand_on(0, n);
        const Hit<Real> hit = first_crossing(here, linear, ray, sides);
        again += !inner && hit.shape == 0 ? 1 : 0;
        inside_out += inner && (hit.shape != 0 || !hit.leaving || !(hit.t > 0)) ? 1 : 0;
      }
    }
  }
  within(23, named<Real>("convex surface met again"), again, 0);
  within(23, named<Real>("other end of an inner chord missed"), inside_out, 0);
}

TEST_CASE("row 24: every sample that hits a single grey sphere is exactly 1/2") {
  constexpr std::uint64_t half = std::uint64_t{1} << 31;
  double other = 0;
  double rays = 0;
  for (const int k : {-20, -1, 0, 7, 30}) {
    const Scene scene = doctor::grey_ball(std::ldexp(1.0, k));
    for (const Precision precision : precisions) {
      RenderSettings settings = sized(24, 24, trials(8), 50);
      settings.precision = precision;
      for (const Tracer& tracer : tracers()) {
        const ReferenceSums sums = tracer.sums(scene, settings);
        other += pixels_other_than(sums, half, settings.samples_per_pixel);
        rays +=
            static_cast<double>(sums.counts.rays) - 2 * static_cast<double>(sums.counts.samples);
      }
    }
  }
  within(24, "pixels with a sample other than 1/2", other, 0);
  within(24, "rays that met the sphere that they leave", std::abs(rays), 0);
}

TEST_CASE("row 25: no path gets out of a closed sphere, or into it") {
  double leaks = 0;
  double bounces = 0;
  double other_length = 0;
  for (const int k : {-20, 0, 10, 30}) {
    for (const double off_centre : {0.0, 0.999}) {
      const Scene scene = doctor::closed_ball(std::ldexp(1.0, k), off_centre);
      for (const Precision precision : precisions) {
        RenderSettings settings = sized(8, 8, trials(1), 1000);
        settings.precision = precision;
        for (const Tracer& tracer : tracers()) {
          const ReferenceSums sums = tracer.sums(scene, settings);
          leaks += pixels_other_than(sums, 0, settings.samples_per_pixel);
          bounces += static_cast<double>(sums.counts.rays);
          other_length += sums.counts.rays == sums.counts.samples * settings.max_depth ? 0 : 1;
        }
      }
    }
  }
  within(25, "leaks in " + std::to_string(static_cast<std::uint64_t>(bounces)) + " bounces", leaks,
         0);
  within(25, "pictures with longer or shorter paths than allowed", other_length, 0);
}

TEST_CASE("row 26: paths in nested glass lose no light and alternate between entry and exit") {
  double dark = 0;
  double crossings = 0;
  for (const Scene& scene : {nested_shells(6, 0x1p-10), limb()}) {
    for (const Precision precision : precisions) {
      RenderSettings settings = sized(16, 16, trials(64), 100'000);
      // With other numbers, total reflection keeps one path in about 1e5 of f32 in an orbit.
      settings.sampler = Sampler::independent;
      settings.precision = precision;
      for (const Tracer& tracer : tracers()) {
        const ReferenceSums sums = tracer.sums(scene, settings);
        dark += pixels_other_than(sums, std::uint64_t{1} << 32, settings.samples_per_pixel);
        crossings += static_cast<double>(sums.counts.rays);
        CHECK(sums.counts.rays > sums.counts.samples * 3 / 2);
      }
    }
  }
  within(26, "lost light in " + std::to_string(static_cast<std::uint64_t>(crossings)) + " segments",
         dark, 0);
}

TEST_CASE_TEMPLATE("row 26: a path that total reflection keeps near the wall stays inside", Real,
                   float, double) {
  // Inside glass of index 1.5, the path meets the surface at 1 - 2^-k of grazing.
  Scene ball = under_white_sky();
  ball.materials = {glass(1.5)};
  ball.spheres = {{{0, 0, 0}, 1, 0}};
  const TracedPicture<Real> scene =
      reference_scene<Real, Real>(ball, sized(4, 4, 1, static_cast<std::uint32_t>(trials(2000))));
  const Linear<Real> linear(scene.spheres);
  double broken = 0;
  double drift = 0;
  for (int k = 1; k <= (sizeof(Real) == sizeof(float) ? 23 : 52); ++k) {
    const double sine = 1 - 0.25 * std::exp2(-k);  // beyond the critical angle, asin(2/3)
    const Vec3<Real> n{0, 1, 0};
    Ray<Real> ray(n, normalize(vec_cast<Real>(Vec3d{sine, -std::sqrt(1 - sine * sine), 0})));
    InsideStack<Real> sides;
    sides.start();
    sides.cross(0, false);
    sides.stand_on(0, n);
    int steps = 0;
    const bool out = follow(scene, linear, ray, sides, SampleRandom(1, 2, 3),
                            [&](const Ray<Real>&, const Hit<Real>& hit, const Scattering<Real>& s) {
                              ++steps;
                              broken += hit.leaving && s.event == Event::reflected ? 0 : 1;
                            });
    broken += out ? 1 : 0;
    const Quad moment = quad_length(cross(exact(ray.origin), exact(ray.direction)));
    const Quad ulp = 2 * static_cast<Quad>(RealTraits<Real>::unit_roundoff);
    drift = std::max(drift,
                     static_cast<double>(quad_abs(moment - static_cast<Quad>(sine)) / ulp) / steps);
  }
  within(26, named<Real>("orbits of total reflection that broke"), broken, 0);
  within(26, named<Real>("drift of their impact parameter / ulp a bounce"), drift, 2);
}

TEST_CASE("row 28: a red sphere shows through a shell of glass, down to 8 ulp thick") {
  // The picture does not change any more below a certain thickness. A shell of 2^-40 gives this
  // limit.
  const auto shell = [](double gap) {
    Scene scene = under_white_sky();
    scene.camera.look_from = {0, 0, 5};
    scene.camera.tan_half_vfov = 0.21;
    scene.materials = {{MaterialType::diffuse, {0.8, 0.1, 0.1}, 0, 1}, glass(1.5)};
    scene.spheres = {{{0, 0, 0}, 1, 0}, {{0, 0, 0}, 1 + gap, 1}};
    return scene;
  };
  RenderSettings settings = sized(24, 24, trials(64), 200);
  settings.precision = Precision::f64;
  const Scene thin = shell(0x1p-40);
  const std::vector<double> limit = means_of(reference_sums(thin, settings), thin, settings);
  for (const auto& [gap, name] :
       {std::pair{4e-5, "4e-5"}, std::pair{1e-6, "1e-6"}, std::pair{8 * 0x1p-23, "8 ulp"}}) {
    for (const Precision precision : precisions) {
      settings.precision = precision;
      const Scene scene = shell(gap);
      double worst = 0;
      for (const Tracer& tracer : tracers()) {
        const std::vector<double> found = means_of(tracer.sums(scene, settings), scene, settings);
        worst = std::max(worst, std::abs(mean_difference(found, limit)));
      }
      within(28,
             "shell of " + std::string(name) + " r, " + std::string(name_of(precision)) +
                 ": |mean - limit of no gap|",
             worst, 1e-3);
    }
  }
  CHECK(mean_distance(limit, std::vector<double>(limit.size(), 1.0)) > 0.2);  // it is red
}

TEST_CASE_TEMPLATE("row 29: paths through nested shells meet the same surfaces as exact paths",
                   Real, float, double) {
  const double ulp = 2 * static_cast<double>(RealTraits<Real>::unit_roundoff);
  RenderSettings settings = sized(12, 12, 1, 24);
  within(29, named<Real>("100 shells, gaps of 2^-8: other paths than exact ones"),
         share_of_other_paths<Real>(nested_shells(100, 0x1p-8), settings, trials(300)), 0.01);
  within(29, named<Real>("6 shells, gaps of 64 ulp: other paths than exact ones"),
         share_of_other_paths<Real>(nested_shells(6, 64 * ulp), settings, trials(600)), 0.03);
}

}  // namespace parray::test
