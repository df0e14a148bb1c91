#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

#include "cli/input/scene_file/scene_file.h"
#include "common/scene/settings.h"
#include "common/trace/integrator/path.h"
#include "common/trace/isa.h"
#include "common/trace/tracer.h"
#include "tests/support/dice.h"
#include "tests/support/lane_accelerator.h"
#include "tests/support/precisions.h"
#include "tests/support/reference_tracer.h"
#include "tests/support/rooms.h"
#include "tests/support/sample_materials.h"
#include "tests/support/shipped_scene.h"
#include "tests/support/tracers.h"

/// Scenes whose every sample is known exactly.
namespace parray {
namespace {

using test::diffuse;
using test::glass;
using test::shipped;
using test::TracedPicture;

constexpr std::uint64_t one = std::uint64_t{1} << 32;  // radiance 1 in fixed point, sky 1

struct FurnacePicture : test::ReferenceSums {
  std::uint32_t spp = 0;

  /// Pixels whose sums are not those of `spp` samples of this fixed-point radiance.
  [[nodiscard]] std::size_t pixels_other_than(std::uint64_t radiance) const {
    return static_cast<std::size_t>(
        std::count_if(pixels.begin(), pixels.end(), [&](const PixelSums& pixel) {
          PixelSums expected;
          for (std::size_t c = 0; c < 3; ++c) {
            expected.sum[c] = spp * radiance;
            expected.sum_of_squares[c] = spp * RadianceScale::square_of(radiance);
            expected.odd[c] = spp / 2 * radiance;
          }
          return !(pixel == expected);
        }));
  }
};

FurnacePicture furnace_picture(const Scene& scene, const RenderSettings& settings) {
  return {test::sums_of(*make_path_tracer(scene, settings), settings), settings.samples_per_pixel};
}

constexpr std::uint32_t furnace_width = 30;
constexpr std::uint32_t furnace_height = 20;
constexpr std::uint32_t furnace_spp = 4;

RenderSettings furnace_settings(RenderSettings settings, Precision precision,
                                AcceleratorKind accelerator) {
  settings.width = furnace_width;
  settings.height = furnace_height;
  settings.samples_per_pixel = furnace_spp;
  settings.precision = precision;
  settings.accelerator = accelerator;
  return settings;
}

/// `check` for every precision and accelerator.
template <typename Check>
void for_all_accelerators(const Scene& scene, const RenderSettings& settings, Check check) {
  for (const Precision precision : test::precisions) {
    for (const AcceleratorKind accelerator : test::accelerators) {
      CAPTURE(name_of(precision));
      CAPTURE(name_of(accelerator));
      const FurnacePicture picture =
          furnace_picture(scene, furnace_settings(settings, precision, accelerator));
      CHECK(picture.counts.samples == std::uint64_t{furnace_width} * furnace_height * furnace_spp);
      CHECK(picture.counts.nonfinite == 0);
      check(picture);
    }
  }
}

Scene under_white_sky() {
  Scene scene;
  scene.sky = {{1, 1, 1}, {1, 1, 1}};
  scene.camera.aperture = 0;
  scene.camera.tan_half_vfov = 0.5;
  return scene;
}

/// Glass within bubbles within glass, and two solid balls that overlap.
Scene nested_glass() {
  Scene scene = under_white_sky();
  scene.camera.look_from = {0, 0.5, 4};
  scene.materials = {glass(1.5), glass(1 / 1.5), glass(1.33), glass(2.4)};
  scene.spheres = {{{0, 0, 0}, 1, 0},         {{0, 0, 0}, 0.95, 1},     {{0.1, 0, 0}, 0.8, 2},
                   {{0.1, 0, 0}, 0.4, 1},     {{0.1, 0, 0}, 0.2, 3},    {{1.5, 0.2, 0.3}, 0.6, 0},
                   {{1.9, 0.2, 0.3}, 0.5, 2}, {{-1.6, 0, 0.5}, 0.6, 3}, {{-1.6, 0, 0.5}, 0.599, 1}};
  return scene;
}

/// Glass sticks within bubbles within glass, sticks that overlap, and one without length.
Scene nested_sticks() {
  Scene scene = under_white_sky();
  scene.camera.look_from = {0, 0.5, 4};
  scene.materials = {glass(1.5), glass(1 / 1.5), glass(1.33), glass(2.4)};
  scene.spheres = {{{-1, 0, 0}, 0.7, 0}};
  scene.capsules = {
      {{-1, 0, 0}, {1, 0.2, 0}, 0.5, 0},         {{-1, 0, 0}, {1, 0.2, 0}, 0.45, 1},
      {{-1, 0, 0}, {1, 0.2, 0}, 0.4499, 2},      {{0, -1, 0.3}, {0, 1, 0.3}, 0.3, 3},
      {{0.5, -1, 0.2}, {0.2, 1, 0}, 0.25, 2},    {{1.5, 0.2, 0.3}, {1.5, 0.2, 0.3}, 0.4, 0},
      {{1.5, 0.2, 0.3}, {1.6, 0.2, 0.3}, 0.2, 1}};
  return scene;
}

/// Follows one path by the kernel's own steps. False: a crossing did not alternate with the one
/// before it of the same sphere, or the path reached the sky from inside of something.
template <typename Real, SphereSearch<Real> S>
bool alternates(const TracedPicture<Real>& scene, const S& search, Ray<Real> ray,
                const SampleRandom& random, std::uint64_t& crossings) {
  InsideStack<Real> sides;
  start_sides(scene, scene, 0, 0, ray.origin, sides);
  std::vector<bool> inside(scene.shape_count(), false);
  for (const std::uint32_t index : sides.inside()) inside[index] = true;
  for (std::uint32_t bounce = 0; bounce < scene.max_depth; ++bounce) {
    const Hit<Real> hit = first_crossing(scene, search, ray, sides);
    if (hit.shape == no_shape) return sides.inside().empty();
    if (hit.leaving != inside[hit.shape] || !(hit.t >= 0)) return false;
    const SurfacePoint<Real> point = surface_point(scene, ray, sides, hit);
    const Vec3<Real>& normal = point.normal;
    const auto scattering = scatter(scene.surfaces[scene.material_of[hit.shape]], ray.direction,
                                    hit.leaving ? -normal : normal, hit.leaving, random, bounce);
    if (scattering.event == Event::absorbed) return true;
    if (scattering.event == Event::refracted) {
      sides.cross(hit.shape, hit.leaving);
      inside[hit.shape] = !hit.leaving;
      ++crossings;
    }
    sides.stand_on(hit.shape, normal);
    ray = {point.position(), scattering.direction};
    const auto depth = static_cast<std::size_t>(std::count(inside.begin(), inside.end(), true));
    if (depth != sides.inside().size()) return false;
  }
  return true;
}

template <typename Real>
TracedPicture<Real> trace_scene(const Scene& scene, std::uint32_t depth) {
  TracedPicture<Real> result{
      {{}, {}, {}, stored_materials<Real>(scene), SkyGradient<Real>(scene.sky)},
      {CameraRays<Real>(scene.camera, furnace_width, furnace_height), {}, depth}};
  add_shapes<Real>(scene, {}, result);
  return result;
}

}  // namespace

TEST_CASE("the shipped furnace is exactly 1 in every sample") {
  const SceneFile file = shipped("furnace.json");
  for_all_accelerators(file.scene, file.settings, [](const FurnacePicture& picture) {
    CHECK(picture.pixels_other_than(one) == 0);
    CHECK(picture.counts.rays > 2 * picture.counts.samples);
  });
}

TEST_CASE("the shipped cavity is exactly 0 in every sample") {
  const SceneFile file = shipped("cavity.json");
  for_all_accelerators(file.scene, file.settings, [&](const FurnacePicture& picture) {
    CHECK(picture.pixels_other_than(0) == 0);
    CHECK(picture.counts.rays == picture.counts.samples * file.settings->max_depth);
  });
}

TEST_CASE("a sample of a lone diffuse sphere of albedo 1/2 is exactly 1/2 at every radius") {
  RenderSettings settings;
  settings.max_depth = 2;
  for (int k = -20; k <= 30; k += 2) {
    CAPTURE(k);
    Scene scene = under_white_sky();
    const double r = std::ldexp(1.0, k);
    scene.camera.look_from = {0, 0, 3 * r};
    scene.materials = {diffuse(0.5)};
    scene.spheres = {{{0, 0, 0}, r, 0}};
    for_all_accelerators(scene, settings, [](const FurnacePicture& picture) {
      std::uint64_t hits = 0;
      for (const PixelSums& pixel : picture.pixels) {
        const std::uint64_t misses = (pixel.sum[0] - furnace_spp * (one / 2)) / (one / 2);
        PixelSums expected;
        const std::uint64_t odd_misses = (pixel.odd[0] - furnace_spp / 2 * (one / 2)) / (one / 2);
        for (std::uint32_t s = 0; s < furnace_spp; ++s) {
          const std::uint64_t missed = s % 2 == 1 ? odd_misses : misses - odd_misses;
          const std::uint64_t value = s / 2 < missed ? one : one / 2;
          expected.add({value, value, value}, s);
        }
        REQUIRE(pixel == expected);
        hits += furnace_spp - misses;
      }
      CHECK(hits > 300);
      CHECK(picture.counts.rays == picture.counts.samples + hits);  // none met the sphere twice
    });
  }
}

TEST_CASE_TEMPLATE("a path never meets the surface it leaves, and inside goes along its chord",
                   Real, float, double) {
  test::Dice dice(9);
  int again = 0;
  int again_without_sides = 0;
  int other_than_chord = 0;
  for (int i = 0; i < 50'000; ++i) {
    Scene one_ball = under_white_sky();
    one_ball.materials = {glass(1.5)};
    one_ball.spheres = {{dice.ten_to(0, 4) * dice.direction(), dice.ten_to(-2, 3), 0}};
    const TracedPicture<Real> scene = trace_scene<Real>(one_ball, 2);
    const Linear<Real> linear(scene.spheres);
    const SphereShape<Real>& sphere = scene.spheres[0];
    const Vec3d n = dice.direction();
    const Vec3d outward = normalize(dice.across(n) + dice.ten_to(-18, 1) * n);
    const Vec3<Real> normal = normalize(vec_cast<Real>(n));
    const Vec3<Real> origin = sphere.center + sphere.radius * normal;
    const Ray<Real> away(origin, vec_cast<Real>(outward));
    const Ray<Real> into(origin, vec_cast<Real>(-outward));
    InsideStack<Real> sides;
    sides.start();
    again_without_sides += first_crossing(scene, linear, away, sides).shape == 0 ? 1 : 0;
    sides.stand_on(0, normal);
    again += first_crossing(scene, linear, away, sides).shape == 0 ? 1 : 0;
    sides.cross(0, false);
    const Hit<Real> end = first_crossing(scene, linear, into, sides);
    other_than_chord += end.leaving && end.t == chord_from_surface(into, sphere, normal) ? 0 : 1;
  }
  CHECK(again == 0);
  CHECK(other_than_chord == 0);
  CHECK(again_without_sides > 1000);  // what computed distances alone would make of it
}

TEST_CASE("nothing leaks out of a closed diffuse sphere at any radius, wherever the camera is") {
  RenderSettings settings;
  settings.max_depth = 100;
  for (int k = -20; k <= 30; k += 10) {
    for (const double off_centre : {0.0, 0.999}) {
      CAPTURE(k);
      CAPTURE(off_centre);
      Scene scene = under_white_sky();
      const double r = std::ldexp(1.0, k);
      scene.camera.look_from = {off_centre * r, 0, 0};
      scene.camera.look_at = {-r, -0.3 * r, 0.2 * r};
      scene.materials = {diffuse(1)};
      scene.spheres = {{{0, 0, 0}, r, 0}};
      for_all_accelerators(scene, settings, [&](const FurnacePicture& picture) {
        CHECK(picture.pixels_other_than(0) == 0);
        CHECK(picture.counts.rays == picture.counts.samples * settings.max_depth);
      });
    }
  }
}

TEST_CASE("nothing leaks into a closed sphere of any material from a camera in it") {
  RenderSettings settings;
  settings.max_depth = 100;
  for (const Material& material : {diffuse(1), Material{MaterialType::metal, {1, 1, 1}, 0, 1},
                                   Material{MaterialType::metal, {1, 1, 1}, 0.5, 1}}) {
    Scene scene = under_white_sky();
    scene.camera.look_from = {700, 0, 0};
    scene.materials = {material, diffuse(1), glass(1.5)};
    // A ground-sized sphere through the wall and a bubble at the camera.
    scene.spheres = {{{0, 0, 0}, 1000, 0}, {{0, -1500, 0}, 900, 1}, {{700, 0, 0}, 2, 2}};
    for_all_accelerators(scene, settings, [](const FurnacePicture& picture) {
      CHECK(picture.pixels_other_than(0) == 0);
    });
  }
}

TEST_CASE("a sample that is not a number is counted and adds nothing, even under an even sky") {
  Scene scene = under_white_sky();
  scene.camera.aperture = 1;
  scene.camera.focus_distance = 1e-300;  // no reader accepts it; in single precision it is 0
  const FurnacePicture picture =
      furnace_picture(scene, furnace_settings({}, Precision::f32, AcceleratorKind::linear));
  CHECK(picture.counts.samples == std::uint64_t{furnace_width} * furnace_height * furnace_spp);
  CHECK(picture.counts.nonfinite == picture.counts.samples);
  CHECK(picture.pixels_other_than(0) == 0);
}

TEST_CASE_TEMPLATE("no material turns a normal that is not a number into plain black", Real, float,
                   double) {
  const Real nan = std::numeric_limits<Real>::quiet_NaN();
  for (const Material& material :
       {diffuse(0.5), glass(1.5), Material{MaterialType::metal, {1, 1, 1}, 0, 1},
        Material{MaterialType::metal, {1, 1, 1}, 0.5, 1}}) {
    for (const bool leaving : {false, true}) {
      const auto scattering = scatter<Real>(MaterialParameters<Real>(material), {0, 1, 0},
                                            {nan, nan, nan}, leaving, SampleRandom(1, 2, 3), 0);
      CHECK(scattering.event != Event::absorbed);
      CHECK(std::isnan(scattering.direction.y));
    }
  }
}

TEST_CASE("glass in glass loses no light") {
  RenderSettings settings;
  settings.max_depth = 100'000;
  for_all_accelerators(nested_glass(), settings, [](const FurnacePicture& picture) {
    CHECK(picture.pixels_other_than(one) == 0);
  });
}

TEST_CASE("glass inside the same glass changes no path, whatever the depth") {
  RenderSettings settings;
  settings.max_depth = 4;  // enough for the ball alone, but not for 60 surfaces inside it
  Scene ball = under_white_sky();
  ball.sky = {{1, 0.5, 0.25}, {0.25, 0.5, 1}};
  ball.camera.look_from = {0, 0.5, 4};
  ball.camera.tan_half_vfov = 0.2;
  ball.materials = {glass(1.5)};
  ball.spheres = {{{0, 0, 0}, 1, 0}};
  Scene filled = ball;
  test::Dice dice(8);
  for (int i = 0; i < 30; ++i) {
    filled.spheres.push_back({dice.in_cube(0.3), dice.between(0.1, 0.4), 0});
    filled.capsules.push_back({dice.in_cube(0.3), dice.in_cube(0.4), 0.1, 0});
  }
  for (const Precision precision : {Precision::f32, Precision::mixed, Precision::f64}) {
    const FurnacePicture alone =
        furnace_picture(ball, furnace_settings(settings, precision, AcceleratorKind::bvh));
    for (const Isa isa : instruction_sets()) {
      settings.isa = isa;
      const FurnacePicture full =
          furnace_picture(filled, furnace_settings(settings, precision, AcceleratorKind::bvh));
      std::uint64_t apart = 0;
      for (std::size_t i = 0; i < alone.pixels.size(); ++i) {
        const auto a = static_cast<double>(alone.pixels[i].sum[0]);
        const auto b = static_cast<double>(full.pixels[i].sum[0]);
        apart += std::abs(a - b) > 1e-4 * a ? 1U : 0U;
      }
      CHECK(apart <= alone.pixels.size() / 100);  // rounding may change a choice of a path
      CHECK(full.counts.rays > alone.counts.rays);
    }
  }
}

TEST_CASE("glass sticks in a white sky are exactly 1 in every sample") {
  RenderSettings settings;
  settings.max_depth = 100'000;
  for_all_accelerators(nested_sticks(), settings, [](const FurnacePicture& picture) {
    CHECK(picture.pixels_other_than(one) == 0);
  });
}

TEST_CASE("a sample of a lone diffuse stick of albedo 1/2 is 1/2 or 1, at every scale") {
  RenderSettings settings;
  settings.max_depth = 2;
  for (int k = -20; k <= 30; k += 10) {
    CAPTURE(k);
    Scene scene = under_white_sky();
    const double r = std::ldexp(1.0, k);
    scene.camera.look_from = {0, r, 5 * r};
    scene.materials = {diffuse(0.5)};
    scene.capsules = {{{-r, 0, 0}, {2 * r, r, -r}, 0.7 * r, 0}};
    for_all_accelerators(scene, settings, [](const FurnacePicture& picture) {
      for (const PixelSums& pixel : picture.pixels) REQUIRE(pixel.sum[0] % (one / 2) == 0);
      CHECK(picture.counts.rays > picture.counts.samples);
    });
  }
}

TEST_CASE_TEMPLATE("a path goes into and out of every stick in turn", Real, float, double) {
  std::uint64_t crossings = 0;
  std::uint64_t broken = 0;
  const TracedPicture<Real> scene = trace_scene<Real>(nested_sticks(), 1000);
  const Linear<Real> linear(scene.spheres);
  for (std::uint32_t pixel = 0; pixel < furnace_width * furnace_height; ++pixel) {
    for (std::uint32_t s = 0; s < 16; ++s) {
      const SampleRandom random(5, pixel, s);
      const Ray<Real> ray =
          scene.view.template ray<Real>(pixel % furnace_width, pixel / furnace_width, random);
      broken += alternates(scene, linear, ray, random, crossings) ? 0U : 1U;
    }
  }
  CHECK(broken == 0);
  CHECK(crossings > 10'000);
}

TEST_CASE("a white metal sphere in a white sky loses nothing but what fuzz absorbs") {
  RenderSettings settings;
  Scene scene = under_white_sky();
  scene.camera.look_from = {0, 0, 3};
  scene.materials = {{MaterialType::metal, {1, 1, 1}, 0, 1}};
  scene.spheres = {{{0, 0, 0}, 1, 0}};
  for_all_accelerators(scene, settings, [](const FurnacePicture& picture) {
    CHECK(picture.pixels_other_than(one) == 0);
  });
  scene.materials[0].fuzz = 1;
  for_all_accelerators(scene, settings, [](const FurnacePicture& picture) {
    for (const PixelSums& pixel : picture.pixels) {
      REQUIRE(pixel.sum[0] % one == 0);  // each sample is all or nothing
    }
    CHECK(picture.pixels_other_than(one) > 0);
  });
}

TEST_CASE_TEMPLATE("a path goes into and out of every sphere in turn", Real, float, double) {
  std::uint64_t crossings = 0;
  std::uint64_t broken = 0;
  const TracedPicture<Real> scene = trace_scene<Real>(nested_glass(), 1000);
  const Linear<Real> linear(scene.spheres);
  const test::LaneTree<Real> tree(scene.spheres);
  for (std::uint32_t pixel = 0; pixel < furnace_width * furnace_height; ++pixel) {
    for (std::uint32_t s = 0; s < 16; ++s) {
      const SampleRandom random(5, pixel, s);
      const Ray<Real> ray =
          scene.view.template ray<Real>(pixel % furnace_width, pixel / furnace_width, random);
      broken += alternates(scene, linear, ray, random, crossings) ? 0U : 1U;
      broken += alternates(scene, tree, ray, random, crossings) ? 0U : 1U;
    }
  }
  CHECK(broken == 0);
  CHECK(crossings > 20'000);
}

TEST_CASE_TEMPLATE("sides alternate for rays that graze a glass ball", Real, float, double) {
  Scene glass_ball = under_white_sky();
  glass_ball.materials = {glass(1.5)};
  glass_ball.spheres = {{{0, 0, 0}, 1, 0}};
  const TracedPicture<Real> scene = trace_scene<Real>(glass_ball, 10'000);
  const Linear<Real> linear(scene.spheres);
  test::Dice dice(6);
  std::uint64_t crossings = 0;
  std::uint64_t broken = 0;
  for (std::uint32_t i = 0; i < 40'000; ++i) {
    const Vec3d axis = dice.direction();
    const Vec3d side = dice.across(axis);
    const double impact = 1 - dice.ten_to(-9, -1);
    const Ray<Real> ray(vec_cast<Real>(impact * side - 3 * axis), vec_cast<Real>(axis));
    broken += alternates(scene, linear, ray, SampleRandom(7, i, 0), crossings) ? 0U : 1U;
  }
  CHECK(broken == 0);
  CHECK(crossings > 10'000);
}

}  // namespace parray
