// Orthographic cameras: where their rays begin and go, and what they begin inside of.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "cli/output/channel_tracing.h"
#include "common/scene/requirements.h"
#include "common/scene/settings.h"
#include "common/trace/integrator/camera_rays.h"
#include "common/trace/integrator/start_shapes.h"
#include "common/trace/tracer.h"
#include "tests/support/dice.h"
#include "tests/support/precisions.h"
#include "tests/support/rooms.h"
#include "tests/support/sample_scenes.h"
#include "tests/support/tracers.h"

namespace parray::test {
namespace {

using LongReal = long double;

Camera orthographic_camera(const Vec3d& from, const Vec3d& at, double view_height) {
  Camera camera;
  camera.look_from = from;
  camera.look_at = at;
  camera.projection = Projection::orthographic;
  camera.view_height = view_height;
  camera.vfov = camera.tan_half_vfov = camera.aperture = 0;
  camera.focus_distance = length(at - from);
  return camera;
}

Vec3<LongReal> long_vec(const Vec3d& v) { return {v.x, v.y, v.z}; }
Vec3<LongReal> unit(const Vec3<LongReal>& v) { return (1 / std::sqrt(dot(v, v))) * v; }

/// The picture's axes, in more digits than any kernel has.
struct ExactAxes {
  explicit ExactAxes(const Camera& c)
      : back(unit(long_vec(c.look_from) - long_vec(c.look_at))),
        right(unit(cross(long_vec(c.up), back))),
        up(cross(back, right)) {}
  Vec3<LongReal> back, right, up;
};

struct Shot {
  Camera camera;
  std::uint32_t width, height, x, y, sample;
};

Shot any_shot(Dice& dice) {
  Shot shot;
  const double scale = dice.ten_to(-6, 6);
  shot.camera = orthographic_camera(scale * dice.in_cube(3), scale * dice.in_cube(1),
                                    scale * dice.ten_to(-2, 2));
  shot.camera.up = dice.direction();
  shot.width = 1 + dice.below32(2000);
  shot.height = 1 + dice.below32(2000);
  shot.x = dice.below32(shot.width);
  shot.y = dice.below32(shot.height);
  shot.sample = dice.below32(1000);
  return shot;
}

template <typename Real>
Ray<Real> ray_of(const Shot& shot) {
  const CameraRays<Real> rays(shot.camera, shot.width, shot.height);
  return rays.template ray<Real>(
      shot.x, shot.y,
      SampleRandom(7, shot.y * shot.width + shot.x, shot.sample, Sampler::independent));
}

/// The point of the film that a sample's ray belongs to.
template <typename Real>
Vec3<LongReal> film_point(const Shot& shot) {
  const SampleRandom random(7, shot.y * shot.width + shot.x, shot.sample, Sampler::independent);
  const auto u = random.template at<Real>(0, Purpose::camera);
  const ExactAxes axes(shot.camera);
  const LongReal height = shot.camera.view_height;
  const LongReal width = height * shot.width / shot.height;
  const LongReal right = ((shot.x + static_cast<LongReal>(u.a)) / shot.width - 0.5L) * width;
  const LongReal down = ((shot.y + static_cast<LongReal>(u.b)) / shot.height - 0.5L) * height;
  return long_vec(shot.camera.look_from) + right * axes.right - down * axes.up;
}

LongReal size_of(const Shot& shot) {
  const double aspect = static_cast<double>(shot.width) / shot.height;
  return length(shot.camera.look_from) + length(shot.camera.look_at) +
         shot.camera.view_height * (1 + aspect);
}

template <typename Real>
void check_rays(Dice& dice) {
  for (int i = 0; i < 2000; ++i) {
    const Shot shot = any_shot(dice);
    const Ray<Real> ray = ray_of<Real>(shot);
    const LongReal ulp = RealTraits<Real>::unit_roundoff;
    const Vec3<LongReal> off = vec_cast<LongReal>(ray.origin) - film_point<Real>(shot);
    CHECK(std::sqrt(dot(off, off)) <= 8 * ulp * size_of(shot));
    const Vec3<LongReal> turn = vec_cast<LongReal>(ray.direction) + ExactAxes(shot.camera).back;
    CHECK(std::sqrt(dot(turn, turn)) <= 8 * ulp);
  }
}

template <typename Real>
void check_focus(Dice& dice) {
  for (int i = 0; i < 2000; ++i) {
    Shot shot = any_shot(dice);
    shot.camera.aperture = shot.camera.view_height * dice.ten_to(-3, 0);
    shot.camera.focus_distance = shot.camera.view_height * dice.ten_to(-0.5, 2);
    const Ray<Real> ray = ray_of<Real>(shot);
    const ExactAxes axes(shot.camera);
    const Vec3<LongReal> middle = film_point<Real>(shot);
    const Vec3<LongReal> from_middle = vec_cast<LongReal>(ray.origin) - middle;
    const LongReal slack = 16 * static_cast<LongReal>(RealTraits<Real>::unit_roundoff) *
                           (size_of(shot) + shot.camera.focus_distance);
    CHECK(std::abs(dot(from_middle, axes.back)) <= slack);
    CHECK(std::sqrt(dot(from_middle, from_middle)) <= shot.camera.aperture / 2 + slack);
    const Vec3<LongReal> direction = vec_cast<LongReal>(ray.direction);
    const LongReal t = shot.camera.focus_distance / -dot(direction, axes.back);
    const Vec3<LongReal> sharp =
        middle - static_cast<LongReal>(shot.camera.focus_distance) * axes.back;
    const Vec3<LongReal> off = vec_cast<LongReal>(ray.origin) + t * direction - sharp;
    CHECK(std::sqrt(dot(off, off)) <= 2 * slack);
  }
}

RenderSettings parallel_settings(std::uint32_t width, std::uint32_t height, std::uint32_t spp,
                                 Precision precision) {
  RenderSettings settings;
  settings.width = width;
  settings.height = height;
  settings.samples_per_pixel = spp;
  settings.precision = precision;
  settings.accelerator = AcceleratorKind::bvh;
  return settings;
}

std::vector<FirstHit> hits_of(const Scene& scene, const RenderSettings& settings) {
  const auto tracer = make_path_tracer(scene, settings);
  const std::size_t in_row = std::size_t{settings.width} * settings.samples_per_pixel;
  std::vector<FirstHit> hits(in_row * settings.height);
  for (std::uint32_t y = 0; y < settings.height; ++y) {
    tracer->first_hits({y, 0, settings.width}, {0, settings.samples_per_pixel},
                       std::span(hits).subspan(y * in_row, in_row));
  }
  return hits;
}

Scene seen_along_z(double view_height, std::vector<Sphere> spheres) {
  Scene scene;
  scene.camera = orthographic_camera({0, 0, 10}, {0, 0, 0}, view_height);
  scene.materials = {{MaterialType::diffuse, {0.5, 0.5, 0.5}, 0, 1},
                     {MaterialType::dielectric, {1, 1, 1}, 0, 1.5}};
  scene.spheres = std::move(spheres);
  return scene;
}

bool holds(const std::optional<PixelBox>& box, std::uint32_t x, std::uint32_t y) {
  return box && box->left <= x && x <= box->right && box->top <= y && y <= box->bottom;
}

/// Spheres about which the start of a ray is nearly undecided, as they are stored.
template <typename Real, typename Store>
void check_starts(Dice& dice) {
  int begun_inside = 0;
  for (int i = 0; i < 4000; ++i) {
    Shot shot = any_shot(dice);
    shot.camera.aperture = dice.one_in(2) ? 0 : shot.camera.view_height * dice.ten_to(-3, 0);
    const Ray<Real> ray = ray_of<Real>(shot);
    const Vec3d way = dice.direction();
    const double distance = shot.camera.view_height * dice.ten_to(-3, 1);
    const Vec3d center = vec_cast<double>(ray.origin) + distance * way;
    const double ulps = dice.between(-40, 40) * RealTraits<Real>::unit_roundoff;
    const double radius = distance + ulps * (distance + length(center));
    if (!(radius > 0)) continue;
    const SphereShape<Store> stored{vec_cast<Store>(center), static_cast<Store>(radius)};
    const SphereShape<Real> sphere{vec_cast<Real>(stored.center), static_cast<Real>(stored.radius)};
    const Vec3<Real> from_center = ray.origin - sphere.center;
    if (!(dot(from_center, from_center) < sphere.radius * sphere.radius)) continue;
    ++begun_inside;
    const RayStarts starts(shot.camera, shot.width, shot.height);
    CHECK(holds(starts.inside(stored), shot.x, shot.y));
    const StartShapes tiles(starts, 1, [&](std::uint32_t) { return starts.inside(stored); });
    CHECK(tiles.of(shot.x, shot.y).size() == 1);
  }
  CHECK(begun_inside > 1000);
}

}  // namespace

TEST_CASE("parallel rays begin on the film and go straight ahead, to the last digits") {
  Dice dice(3);
  check_rays<float>(dice);
  check_rays<double>(dice);
}

TEST_CASE("the rays of a lens meet straight ahead of its middle, where the focus is") {
  Dice dice(4);
  check_focus<float>(dice);
  check_focus<double>(dice);
}

TEST_CASE("a sphere is as large in the picture wherever it lies along the view") {
  for (const Precision precision : precisions) {
    CAPTURE(name_of(precision));
    const RenderSettings settings = parallel_settings(40, 30, 4, precision);
    const auto covered = [&](double z) {
      const auto hits = hits_of(seen_along_z(4, {{{0.5, 0.25, z}, 1, 0}}), settings);
      return std::ranges::count_if(hits, [](const FirstHit& h) { return h.shape == 0; });
    };
    const auto near = covered(0);
    CHECK(static_cast<double>(near) / (40 * 30 * 4) ==
          doctest::Approx(std::acos(-1.0) / (4 * 4 * 40.0 / 30)).epsilon(0.01));
    CHECK(covered(-20) == near);
    CHECK(std::abs(covered(-1e4) - near) <= 8);
  }
}

TEST_CASE("depth is measured from the camera's plane, the same at the corners as in the middle") {
  for (const Precision precision : precisions) {
    for (const double aperture : {0.0, 0.5}) {
      CAPTURE(name_of(precision));
      Scene scene = seen_along_z(2, {{{0, 0, 3 - 1e5}, 1e5, 0}});
      scene.camera.aperture = aperture;
      const RenderSettings settings = parallel_settings(8, 8, 5, precision);
      const auto tracer = make_path_tracer(scene, settings);
      const Channels channels = trace_channels(*tracer, scene, settings, {Aov::depth}, 1);
      for (const float z : std::get<std::vector<float>>(channels.at(0).values)) {
        CHECK(z == doctest::Approx(7).epsilon(0.01));
      }
    }
  }
}

TEST_CASE("of a sphere that the camera's plane cuts its inside is seen, in the cut alone") {
  for (const Precision precision : precisions) {
    CAPTURE(name_of(precision));
    // The plane z = 10 cuts it in a disc of radius 0.6; most of it lies behind the camera.
    const Scene scene = seen_along_z(2, {{{0, 0, 10.8}, 1, 0}});
    const RenderSettings settings = parallel_settings(64, 64, 3, precision);
    const auto hits = hits_of(scene, settings);
    const double disc = std::acos(-1.0) * 0.36 / 4;
    std::size_t inside = 0;
    std::size_t sky = 0;
    for (const FirstHit& hit : hits) {
      if (hit.shape == no_shape) {
        ++sky;
      } else {
        ++inside;
        CHECK(hit.normal.z > 0.79);  // the far wall, from within
        CHECK(hit.distance < 0.201);
      }
    }
    CHECK(sky + inside == hits.size());
    CHECK(static_cast<double>(inside) / static_cast<double>(hits.size()) ==
          doctest::Approx(disc).epsilon(0.02));
  }
}

TEST_CASE("every sphere that a parallel ray can begin in is asked for its pixel") {
  Dice dice(12);
  check_starts<float, float>(dice);
  check_starts<double, float>(dice);
  check_starts<double, double>(dice);
}

TEST_CASE("of very many spheres that a camera cuts each pixel asks a few") {
  Dice dice(5);
  const Camera camera = orthographic_camera({0, 0, 0}, {0, 0, -1}, 100);
  std::vector<SphereShape<float>> spheres;
  for (int i = 0; i < 20'000; ++i) {
    const Vec3d at = dice.in_cube(50);
    spheres.push_back({vec_cast<float>(Vec3d{at.x, at.y, 0.3 * dice.between(-1, 1)}), 0.5F});
  }
  for (int i = 0; i < 5; ++i) spheres.push_back({{0, 0, 0}, 1000});
  const RayStarts starts(camera, 800, 800);
  const auto count = static_cast<std::uint32_t>(spheres.size());
  const StartShapes tiles(starts, count,
                          [&](std::uint32_t i) { return starts.inside(spheres[i]); });
  std::size_t most = 0;
  std::size_t sum = 0;
  for (std::uint32_t y = 0; y < 800; y += 7) {
    for (std::uint32_t x = 0; x < 800; x += 7) {
      const auto asked = tiles.of(x, y);
      CHECK(std::ranges::is_sorted(asked));
      most = std::max(most, asked.size());
      sum += asked.size();
    }
  }
  CHECK(most < 60);
  CHECK(sum >= 5 * 115 * 115);  // everybody asks the large ones
}

TEST_CASE("single precision is enough where a picture's own height cannot tell") {
  Scene scene = seen_along_z(4, {{{0, 0, 0}, 1, 0}});
  const auto precision_of = [&] {
    return resolve_settings(requirements_of(scene), {}).settings->precision;
  };
  CHECK(requirements_of(scene).view_height == 4);
  CHECK(precision_of() == Precision::f32);
  scene.camera.look_from.z = 0x1p20;  // far: its digits are too few, those of the spheres are not
  CHECK(precision_of() == Precision::mixed);
  scene.camera.look_from.z = 10;
  scene.camera.view_height = 1e-5;
  scene.spheres[0].center.x = 0.1;
  CHECK(precision_of() == Precision::f64);
  scene.camera.view_height = 1e9;  // rays begin far from look_from
  scene.spheres[0].center.x = 0;
  CHECK(precision_of() == Precision::mixed);
  CHECK(requirements_of(scene).extent == 10 + 5e8);
}

TEST_CASE("views of any height and cameras at any distance trace alike everywhere") {
  for (const double view_height : {1e-15, 1e-6, 3.0, 1e9, 1e15}) {
    for (const double distance : {1e-6, 10.0, 1e9, 9e14}) {
      for (const Precision precision : precisions) {
        CAPTURE(view_height);
        CAPTURE(distance);
        CAPTURE(name_of(precision));
        Scene scene = small_scene();
        const Vec3d back = normalize(scene.camera.look_from);
        scene.camera = orthographic_camera(distance * back, {0, 0, 0}, view_height);
        scene.camera.aperture = view_height / 16;
        RenderSettings settings = parallel_settings(9, 7, 3, precision);
        const ReferenceSums expected = reference_sums(scene, settings);
        CHECK(expected.counts.nonfinite == 0);
        for (const Tracer& tracer : tracers()) {
          CAPTURE(tracer.name);
          CHECK_UNARY(tracer.sums(scene, settings).pixels == expected.pixels);
        }
      }
    }
  }
}

TEST_CASE("a widest picture of the highest view stays finite") {
  Scene scene = small_scene();
  scene.camera = orthographic_camera({13, 2, 3}, {0, 0, 0}, 1e15);
  for (const Precision precision : precisions) {
    const RenderSettings settings = parallel_settings(65536, 1, 1, precision);
    CHECK(lane_sums(scene, settings).counts.nonfinite == 0);
  }
}

TEST_CASE("the bits of an orthographic picture are the same for every instruction set") {
  Scene scene = small_scene();
  scene.camera = orthographic_camera({13, 2, 3}, {0, 0.5, 0}, 5);
  scene.camera.aperture = 0.1;
  for (const Isa isa : instruction_sets()) {
    CAPTURE(name_of(isa));
    RenderSettings settings = small_settings(scene);
    settings.isa = isa;
    CHECK(settings.precision == Precision::f32);
    CHECK(reference_sha256(scene, settings) ==
          "95b736feb723ef4c3d07964e4ef733631bf080dc879fa739ca8e47a2bb868c56");
  }
}

}  // namespace parray::test
