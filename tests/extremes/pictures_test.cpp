// Rows 39 to 52 of the table of numerical extremes: changes that must keep a picture's bits, and
// changes that may alter them a little.
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <string>
#include <vector>

#include "cli/check/doctor/extremes.h"
#include "common/scene/settings.h"
#include "tests/support/extremes.h"
#include "tests/support/path_steps.h"
#include "tests/support/precisions.h"
#include "tests/support/rooms.h"
#include "tests/support/sample_scenes.h"
#include "tests/support/shipped_scene.h"
#include "tests/support/sphere_cases.h"
#include "tests/support/tracers.h"

namespace parray::test {
namespace {

using doctor::scaled;
using doctor::sized;

Scene moved(Scene scene, const Vec3d& by) {
  scene.camera.look_from = scene.camera.look_from + by;
  scene.camera.look_at = scene.camera.look_at + by;
  for (Sphere& sphere : scene.spheres) sphere.center = sphere.center + by;
  return scene;
}

/// Returns a scene whose coordinates are multiples of 2^-10, so that moving it far rounds none of
/// them.
Scene on_grid(Scene scene) {
  const auto round = [](const Vec3d& v) {
    const auto one = [](double x) { return std::floor(x * 1024) / 1024; };
    return Vec3d{one(v.x), one(v.y), one(v.z)};
  };
  scene.camera.look_from = round(scene.camera.look_from);
  scene.camera.look_at = round(scene.camera.look_at);
  for (Sphere& sphere : scene.spheres) sphere.center = round(sphere.center);
  return scene;
}

/// Returns the sum of `differ(tracer, settings)` over all tracers and precisions.
template <typename Differ>
double sum_over_tracers(RenderSettings settings, Differ differ) {
  double sum = 0;
  for (const Precision precision : precisions) {
    settings.precision = precision;
    for (const Tracer& tracer : tracers()) sum += differ(tracer, settings);
  }
  return sum;
}

}  // namespace

TEST_CASE("row 44: f32 and f64 follow the same paths except for one in a thousand, without bias") {
  const Scene scene = shipped("one-weekend-20.json").scene;
  RenderSettings settings = sized(60, 40, trials(16), 12);
  const auto single = reference_scene<float, float>(scene, settings);
  const auto whole = reference_scene<double, double>(scene, settings);
  const Linear<float> single_linear(single.spheres);
  const Linear<double> whole_linear(whole.spheres);
  double other = 0;
  const std::uint32_t paths = 60 * 40 * 8;
  for (std::uint32_t i = 0; i < paths; ++i) {
    const std::uint32_t pixel = i % 2400;
    const SampleRandom random(settings.seed, pixel, i / 2400);
    other += steps_of(single, single_linear, pixel % 60, pixel / 60, random) ==
                     steps_of(whole, whole_linear, pixel % 60, pixel / 60, random)
                 ? 0
                 : 1;
  }
  within(44, "share of f32 paths other than f64's, One Weekend", other / paths, 1e-3);
  settings.samples_per_pixel = static_cast<std::uint32_t>(trials(256));
  settings.precision = Precision::f64;
  const std::vector<double> exactly = means_of(lane_sums(scene, settings), scene, settings);
  for (const Precision precision : {Precision::f32, Precision::mixed}) {
    settings.precision = precision;
    const std::vector<double> found = means_of(lane_sums(scene, settings), scene, settings);
    within(44, "|paired mean difference to f64|, " + std::string(name_of(precision)),
           std::abs(mean_difference(found, exactly)), 1e-5);
  }
}

TEST_CASE("rows 1, 44: 113 bits and f64 follow the same paths except for two in a thousand") {
  const Scene scene = shipped("one-weekend-20.json").scene;
  const RenderSettings settings = sized(32, 32, 1, 10);
  const TracedPicture<Quad> traced = exact_scene(scene, settings);
  const Linear<Quad> linear(traced.spheres);
  const TracedPicture<double> whole = reference_scene<double, double>(scene, settings);
  const Linear<double> whole_linear(whole.spheres);
  double other = 0;
  const auto paths = static_cast<std::uint32_t>(trials(4000));
  for (std::uint32_t i = 0; i < paths; ++i) {
    const std::uint32_t x = i % 32;
    const std::uint32_t y = i / 32 % 32;
    const SampleRandom random(seeded(1), i % 1024, i / 1024);
    InsideStack<Quad> exact_sides;
    InsideStack<double> sides;
    TraceCounts counts;
    const auto exactly = trace_sample(traced, traced, linear, x, y, random, exact_sides, counts);
    const auto found = trace_sample(whole, whole, whole_linear, x, y, random, sides, counts);
    other += quad_length(exact(found) - exactly) <= Quad(0x1p-38) ? 0 : 1;
  }
  within(44, "share of f64's samples more than 2^-38 from those of 113 bits", other / paths, 0.002);
}

TEST_CASE("row 39: a pixel's sum of a million large and small samples is exact") {
  const RadianceScale scale(1);
  PixelSums pixel;
  TraceCounts counts;
  float in_float = 0;
  for (std::uint32_t i = 0; i < 1U << 20; ++i) {
    add_sample({0.5, 0x1p-30, i % 2 == 0 ? 1.0 : 0x1p-32}, scale, i, pixel, counts);
    in_float += i % 2 == 0 ? 1.0F : 0x1p-32F;
  }
  const double error = std::max({std::abs(scale.mean(pixel.sum[0], 1U << 20) - 0.5),
                                 std::abs(scale.mean(pixel.sum[1], 1U << 20) - 0x1p-30),
                                 std::abs(scale.mean(pixel.sum[2], 1U << 20) - 0.5 - 0x1p-33)});
  within(39, "error of a mean of 2^20 samples", error, 0);
  CHECK(in_float / 0x1p20F == 0.5F);  // a sum in float loses the last sample
}

TEST_CASE("row 42: pixels, samples and bounces are independent, and noise decreases as it must") {
  // A grey ball fills the picture, so a sample's value depends on one random number of its first
  // bounce.
  Scene scene;
  scene.sky = {{0, 0, 0}, {1, 1, 1}};
  scene.camera.look_from = {0, 0, 1000};
  scene.camera.tan_half_vfov = 0.0005;
  scene.camera.aperture = 0;
  scene.materials = {{MaterialType::diffuse, {1, 1, 1}, 0, 1}};
  scene.spheres = {{{0, 0, 0}, 1, 0}};
  RenderSettings settings = sized(32, 32, 1, 2);
  settings.precision = Precision::f64;
  settings.sampler =
      Sampler::independent;  // its noise decreases with the square root of the number of samples
  const auto deviation = [&](const std::vector<double>& means) {
    double square = 0;
    for (std::uint32_t pixel = 0; pixel < 1024; ++pixel) {
      const double n_y = (15.5 - pixel / 32) / 32.0;
      const double off = means[3UL * pixel] - (0.5 + n_y / 3);
      square += off * off / 1024;
    }
    return square;
  };
  std::array<double, 5> variance{};
  for (const Tracer& tracer : tracers()) {
    for (std::size_t k = 0; k < variance.size(); ++k) {
      settings.samples_per_pixel = 1U << (2 * k);
      variance[k] = deviation(means_of(tracer.sums(scene, settings), scene, settings));
    }
    const double slope = std::log(variance[4] / variance[0]) / std::log(256.0);
    within(42, "|1 + slope of variance over samples|", std::abs(1 + slope), 0.03);
    // Also checks the mean over pixels: dependent pixels would deviate together.
    const auto means = means_of(tracer.sums(scene, settings), scene, settings);
    const double mean = std::accumulate(means.begin(), means.end(), 0.0) / 3072;
    within(42, "mean of all pixels: |z|", std::abs(mean - 0.5) / std::sqrt(variance[4] / 1024),
           4.5);
  }
}

TEST_CASE("row 45: samples that are not finite are counted and add nothing") {
  Scene scene = small_scene();
  scene.camera.aperture = 1;
  scene.camera.focus_distance =
      1e-300;  // no scene file allows this number; in single precision it is 0
  RenderSettings settings = sized(16, 12, 4, 8);
  settings.precision = Precision::f32;
  for (const Tracer& tracer : tracers()) {
    const ReferenceSums sums = tracer.sums(scene, settings);
    within(45, "samples that are not finite, less those counted",
           static_cast<double>(sums.counts.samples - sums.counts.nonfinite), 0);
    CHECK(std::all_of(sums.pixels.begin(), sums.pixels.end(),
                      [](const PixelSums& pixel) { return pixel == PixelSums{}; }));
  }
}

TEST_CASE("row 47: scaling a scene by 2^k, k = -40 .. 40, keeps every bit") {
  const Scene scene = small_scene();
  const double different = sum_over_tracers(
      sized(16, 12, trials(4), 12), [&](const Tracer& tracer, const auto& settings) {
        const auto here = tracer.sums(scene, settings).pixels;
        double other = 0;
        for (int k = -40; k <= 40; ++k) {
          other += tracer.sums(scaled(scene, k), settings).pixels == here ? 0 : 1;
        }
        return other;
      });
  within(47, "scales whose picture differs, of 81 x 3 precisions x tracers", different, 0);
}

TEST_CASE("row 47: scaling a scene far from 0 keeps every bit") {
  const Scene scene = moved(on_grid(small_scene()), {0x1p20, -3 * 0x1p20, 0x1p18});
  const double different = sum_over_tracers(
      sized(12, 9, trials(2), 12), [&](const Tracer& tracer, const auto& settings) {
        const auto here = tracer.sums(scene, settings).pixels;
        double other = 0;
        for (int k = -40; k <= 28; k += 4) {
          other += tracer.sums(scaled(scene, k), settings).pixels == here ? 0 : 1;
        }
        return other;
      });
  within(47, "scales of a far scene whose picture differs", different, 0);
}

TEST_CASE("row 47: in f64 scales of 2^-400 .. 2^400 keep every bit") {
  const Scene scene = small_scene();
  RenderSettings settings = sized(12, 9, trials(2), 12);
  settings.precision = Precision::f64;
  double different = 0;
  for (const Tracer& tracer : tracers()) {
    const auto here = tracer.sums(scene, settings).pixels;
    for (int k = -400; k <= 400; k += 10) {
      different += tracer.sums(scaled(scene, k), settings).pixels == here ? 0 : 1;
    }
  }
  within(47, "scales whose f64 picture differs", different, 0);
}

TEST_CASE_TEMPLATE("row 48: mirroring a ray keeps its distance, and turning it keeps it to 8 ulp",
                   Real, float, double) {
  Dice dice(seeded(48));
  double mirrored = 0;
  double turned = 0;
  for (std::uint64_t i = 0; i < trials(30'000); ++i) {
    const auto c = sphere_case<Real>(dice, 6, dice.between(0, 0.99), 1.01, 1e4);
    const auto flip = [](const Vec3<Real>& v) { return Vec3<Real>{-v.x, v.y, -v.z}; };
    const auto swap = [](const Vec3<Real>& v) { return Vec3<Real>{v.y, v.z, v.x}; };
    Real t = -1;
    Real u = -1;
    Real v = -1;
    const bool hit = enters(c.ray, c.sphere, t);
    const bool flipped = enters(Ray<Real>(flip(c.ray.origin), flip(c.ray.direction)),
                                SphereShape<Real>{flip(c.sphere.center), c.sphere.radius}, u);
    const bool swapped = enters(Ray<Real>(swap(c.ray.origin), swap(c.ray.direction)),
                                SphereShape<Real>{swap(c.sphere.center), c.sphere.radius}, v);
    mirrored += hit == flipped && t == u ? 0 : 1;
    if (hit && swapped) {
      const Exact<Real> truth(c.ray, c.sphere);
      turned = std::max(turned, truth.forward_error(v, static_cast<Quad>(t)));
    }
  }
  const std::string name = sizeof(Real) == sizeof(float) ? ", f32" : ", f64";
  within(48, "mirrored rays with another distance" + name, mirrored, 0);
  within(48, "turned axes: |t - t'| x sqrt(1 - b^2) / ulp(S)" + name, turned, 8);
}

TEST_CASE("row 49: the order of the spheres does not change a bit") {
  Dice dice(seeded(49));
  const Scene scene = small_scene();
  const double different = sum_over_tracers(
      sized(16, 12, trials(4), 12), [&](const Tracer& tracer, const auto& settings) {
        const auto here = tracer.sums(scene, settings).pixels;
        double other = 0;
        for (int i = 0; i < 15; ++i) {
          Scene shuffled = scene;
          for (std::size_t k = shuffled.spheres.size(); k > 1; --k) {
            std::swap(shuffled.spheres[k - 1], shuffled.spheres[dice.below(k)]);
          }
          other += tracer.sums(shuffled, settings).pixels == here ? 0 : 1;
        }
        return other;
      });
  within(49, "orders whose picture differs", different, 0);
}

TEST_CASE("row 49: the order of thousands of spheres far from 0 does not change a bit") {
  Dice dice(seeded(50));
  Scene scene;
  const Vec3d far{1e7, -3e6, 2e6};
  scene.camera.look_from = far + Vec3d{0, 0, 30};
  scene.camera.look_at = far;
  scene.camera.tan_half_vfov = 0.4;
  scene.materials = {{MaterialType::diffuse, {0.5, 0.6, 0.7}, 0, 1}};
  for (int i = 0; i < 3000; ++i) {
    scene.spheres.push_back({far + dice.in_cube(10), dice.between(0.1, 0.5), 0});
  }
  RenderSettings settings = sized(24, 16, 4, 8);
  settings.precision = Precision::f32;
  settings.accelerator = AcceleratorKind::bvh;
  const auto here = lane_sums(scene, settings).pixels;
  double different = 0;
  for (int i = 0; i < 5; ++i) {
    Scene shuffled = scene;
    for (std::size_t k = shuffled.spheres.size(); k > 1; --k) {
      std::swap(shuffled.spheres[k - 1], shuffled.spheres[dice.below(k)]);
    }
    different += lane_sums(shuffled, settings).pixels == here ? 0 : 1;
  }
  within(49, "orders of 3000 far spheres whose f32 picture differs", different, 0);
}

TEST_CASE("row 50: invisible spheres do not change a bit") {
  const Scene scene = small_scene();
  Scene more = scene;
  more.spheres.insert(more.spheres.begin() + 2, {{4, 1, 0}, 0.5, 0});  // inside the metal ball
  more.spheres.push_back({{-4, 1, 0}, 0.99, 1});                       // inside the diffuse one
  more.spheres.push_back({{0, -1000, 0}, 900, 2});                     // inside the ground
  more.spheres.push_back({{3, -400, 0}, 1e-6, 0});                     // a speck of dust there
  more.spheres.push_back({{1e9, -3e9, 1e9}, 1, 0});                    // far below the horizon
  const double different = sum_over_tracers(
      sized(16, 12, trials(32), 12), [&](const Tracer& tracer, const auto& settings) {
        return tracer.sums(more, settings).pixels == tracer.sums(scene, settings).pixels ? 0.0
                                                                                         : 1.0;
      });
  within(50, "pictures with invisible spheres that differ", different, 0);
}

TEST_CASE(
    "row 51: moving a scene to 1e7 changes the mean by 1e-6, moving it further changes nothing") {
  const Scene here = on_grid(small_scene());
  const Vec3d step{10 * 0x1p20, -3 * 0x1p20, 0x1p20};
  const double different = sum_over_tracers(
      sized(16, 12, trials(8), 12), [&](const Tracer& tracer, const auto& settings) {
        const auto there = tracer.sums(moved(here, step), settings).pixels;
        const auto farther = tracer.sums(moved(here, Vec3d{-2 * step.x, 5, 7}), settings).pixels;
        return there == farther ? 0.0 : 1.0;
      });
  within(51, "two far places whose pictures differ", different, 0);
  const Scene there = moved(here, step);
  RenderSettings settings = sized(96, 64, trials(256), 12);
  for (const Precision precision : precisions) {
    settings.precision = precision;
    const std::vector<double> a = means_of(lane_sums(here, settings), here, settings);
    const std::vector<double> b = means_of(lane_sums(there, settings), there, settings);
    within(51, "moved by 1e7, |difference of means|, " + std::string(name_of(precision)),
           std::abs(mean_difference(a, b)), 1e-6);
  }
}

TEST_CASE(
    "row 52: twice the sky gives twice the picture, and two skies give the sum of their pictures") {
  const Scene scene = small_scene();
  Scene twice = scene;
  twice.sky = {2.0 * scene.sky.horizon, 2.0 * scene.sky.zenith};
  Scene dim = scene;
  dim.sky = {0.5 * scene.sky.horizon, 0.5 * scene.sky.zenith};
  const double different = sum_over_tracers(
      sized(16, 12, trials(8), 12), [&](const Tracer& tracer, const auto& settings) {
        const auto one = tracer.sums(scene, settings).pixels;  // the scale follows the sky
        return (tracer.sums(twice, settings).pixels == one ? 0.0 : 1.0) +
               (tracer.sums(dim, settings).pixels == one ? 0.0 : 1.0);
      });
  within(52, "pictures under twice or half the sky that differ", different, 0);

  Scene blue = scene;
  blue.sky = {{0.1, 0.2, 0.9}, {0, 0.1, 0.4}};
  Scene sum = scene;
  sum.sky = {scene.sky.horizon + blue.sky.horizon, scene.sky.zenith + blue.sky.zenith};
  RenderSettings settings = sized(16, 12, trials(8), 12);
  settings.precision = Precision::f64;
  double worst = 0;
  for (const Tracer& tracer : tracers()) {
    const auto a = means_of(tracer.sums(scene, settings), scene, settings);
    const auto b = means_of(tracer.sums(blue, settings), blue, settings);
    const auto both = means_of(tracer.sums(sum, settings), sum, settings);
    for (std::size_t i = 0; i < both.size(); ++i) {
      worst = std::max(worst, std::abs(a[i] + b[i] - both[i]));
    }
  }
  within(52, "|A + B - (A + B)| / 2^-33, f64", worst / 0x1p-33, 4);
}

}  // namespace parray::test
