#include <doctest/doctest.h>

#include <memory>
#include <vector>

#include "common/math/float_mode.h"
#include "common/scene/settings.h"
#include "common/trace/integrator/scene_parts.h"
#include "common/trace/integrator/start_shapes.h"
#include "common/trace/isa.h"
#include "common/trace/reference/octree.h"
#include "common/trace/tracer.h"
#include "tests/support/dice.h"
#include "tests/support/lane_search.h"
#include "tests/support/precisions.h"
#include "tests/support/rooms.h"
#include "tests/support/sample_scenes.h"
#include "tests/support/tracers.h"

/// What one accelerator serves, and for how long.
namespace parray::test {
namespace {

/// Enough spheres for a tree of several levels.
Scene crowd() {
  Scene scene = small_scene();
  Dice dice(3);
  for (int i = 0; i < 300; ++i) {
    scene.spheres.push_back({dice.in_cube(3), dice.between(0.05, 0.3), dice.below32(4)});
  }
  return scene;
}

/// Pictures that differ in all that an accelerator does not know: size, seed, sampler, depth and
/// camera. The last one's lens reaches into spheres, so that paths begin inside of glass.
struct View {
  Camera camera;
  RenderSettings settings;
};
std::vector<View> views_of(const Scene& scene) {
  RenderSettings settings;
  settings.width = 23;
  settings.height = 11;
  settings.samples_per_pixel = 3;
  settings.max_depth = 9;
  settings.sampler = Sampler::independent;
  std::vector<View> views{{scene.camera, settings}};
  settings.width = 14;
  settings.height = 17;
  settings.seed = 0xFEDCBA9876543210;
  settings.sampler = Sampler::sobol;
  settings.max_depth = 4;
  views.push_back({scene.camera, settings});
  views.back().camera.look_from = {-3, 1, 4};
  views.back().camera.aperture = 0;
  settings.max_depth = 20;
  views.push_back({scene.camera, settings});
  views.back().camera.look_from = scene.spheres.back().center;
  views.back().camera.aperture = 0.6;
  return views;
}

}  // namespace

TEST_CASE(
    "one accelerator serves all sizes, seeds, samplers and cameras, as one of their own would") {
  const FloatMode ieee;
  const Scene scene = crowd();
  const std::vector<View> views = views_of(scene);
  for (const Precision precision : precisions) {
    CAPTURE(name_of(precision));
    for (const AcceleratorKind kind : accelerators) {
      CAPTURE(name_of(kind));
      for (const Isa isa : instruction_sets()) {
        CAPTURE(name_of(isa));
        const auto shared = make_accelerator(scene, precision, kind, isa, 2);
        std::vector<std::unique_ptr<PathTracer>> tracers;
        for (View view : views) {
          view.settings.precision = precision;
          tracers.push_back(make_path_tracer(shared, view.camera, view.settings));
          CHECK(tracers.back()->accelerator() == shared);
        }
        for (std::size_t i = 0; i < views.size(); ++i) {
          CAPTURE(i);
          Scene seen = scene;
          seen.camera = views[i].camera;
          RenderSettings settings = views[i].settings;
          settings.precision = precision;
          settings.accelerator = kind;
          settings.isa = isa;
          const ReferenceSums expected = sums_of(*make_path_tracer(seen, settings), settings);
          CHECK_UNARY(sums_of(*tracers[i], settings) == expected);
        }
      }
    }
  }
}

TEST_CASE("a tracer needs neither the scene nor anybody else to keep its accelerator") {
  const FloatMode ieee;
  for (const AcceleratorKind kind : accelerators) {
    CAPTURE(name_of(kind));
    RenderSettings settings = small_settings(small_scene());
    settings.accelerator = kind;
    const ReferenceSums expected = reference_sums(small_scene(), settings);
    auto scene = std::make_unique<Scene>(small_scene());
    auto tracer = make_path_tracer(*scene, settings);
    const std::weak_ptr<const Accelerator> accelerator = tracer->accelerator();
    scene->materials.clear();
    scene->spheres.clear();
    scene->spheres.shrink_to_fit();
    scene.reset();
    CHECK_UNARY(sums_of(*tracer, settings) == expected);
    tracer.reset();
    CHECK(accelerator.expired());
  }
}

TEST_CASE("an accelerator says what it was made for, and which settings it serves") {
  RenderSettings settings = small_settings(small_scene());
  for (const Precision precision : precisions) {
    for (const AcceleratorKind kind : accelerators) {
      const bool octree = kind == AcceleratorKind::octree;  // scalar, whatever is asked for
      const auto accelerator = make_accelerator(small_scene(), precision, kind, Isa::automatic);
      CHECK(accelerator->precision() == precision);
      CHECK(accelerator->kind() == kind);
      CHECK(accelerator->isa() == (octree ? Isa::scalar : best_isa()));
      CHECK(isa_for(kind, Isa::automatic) == accelerator->isa());
      CHECK(isa_for(kind, Isa::scalar) == Isa::scalar);
      CHECK(accelerator->bytes() > 0);
      settings.precision = precision;
      settings.accelerator = kind;
      settings.isa = Isa::automatic;
      CHECK(serves(*accelerator, settings));
      settings.isa = best_isa();
      CHECK(serves(*accelerator, settings));
      settings.isa = Isa::scalar;
      CHECK(serves(*accelerator, settings) == (octree || best_isa() == Isa::scalar));
      settings.isa = Isa::automatic;
      settings.precision = precision == Precision::f64 ? Precision::f32 : Precision::f64;
      CHECK_FALSE(serves(*accelerator, settings));
      settings.precision = precision;
      settings.accelerator = octree ? AcceleratorKind::bvh : AcceleratorKind::octree;
      CHECK_FALSE(serves(*accelerator, settings));
    }
  }
}

TEST_CASE("the memory of an octree includes capsules, and the spheres that its paths look up") {
  const auto beside_search = [](const Scene& of) {
    const auto accelerator =
        make_accelerator(of, Precision::f32, AcceleratorKind::octree, Isa::automatic);
    std::vector<SphereShape<float>> spheres;
    for (const Sphere& sphere : of.spheres) {
      spheres.push_back(stored_shape<float>(sphere, accelerator->origin()));
    }
    return accelerator->bytes() - Octree<float>(spheres).bytes();
  };
  Scene scene = crowd();
  const std::size_t of_spheres = scene.spheres.size() * sizeof(SphereShape<float>);
  CHECK(beside_search(scene) >= of_spheres);
  scene.capsules.assign(1000, Capsule{{1, 0, 0}, {2, 0, 0}, 0.1, 0});
  CHECK(beside_search(scene) >= of_spheres + 1000 * sizeof(CapsuleShape<float>));
}

/// Spheres whose surface the lens's rim nearly touches, as they are stored: a path that begins in
/// one is never told that it is outside.
template <typename Real, typename Store>
void check_reach_of_lens(Dice& dice) {
  const FloatMode ieee;
  int begun_inside = 0;
  for (int i = 0; i < 3000; ++i) {
    Camera camera;
    const double scale = dice.ten_to(-3, 3);
    camera.look_from = scale * dice.in_cube(1);
    camera.aperture = scale * dice.ten_to(-3, 1);
    const Vec3d way = dice.direction();
    const double distance = camera.aperture * dice.ten_to(-1, 3);
    const double ulps = dice.between(-40, 40) * RealTraits<Real>::unit_roundoff;
    const Vec3d center = camera.look_from + distance * way;
    const double radius = distance - camera.aperture / 2 + ulps * (distance + length(center));
    if (!(radius > 0)) continue;
    const SphereShape<Store> stored{vec_cast<Store>(center), static_cast<Store>(radius)};
    const SphereShape<Real> sphere{vec_cast<Real>(stored.center), static_cast<Real>(stored.radius)};
    const Vec3<Real> rim =
        vec_cast<Real>(camera.look_from) + vec_cast<Real>((camera.aperture / 2) * way);
    const Vec3<Real> from_center = rim - sphere.center;
    const bool inside = dot(from_center, from_center) < sphere.radius * sphere.radius;
    begun_inside += inside ? 1 : 0;
    CHECK((!inside || RayStarts(camera, 1, 1).inside(stored).has_value()));
  }
  CHECK(begun_inside > 100);
}

TEST_CASE("every sphere that a path can begin in is among those around the lens") {
  Dice dice(11);
  check_reach_of_lens<float, float>(dice);
  check_reach_of_lens<double, float>(dice);
  check_reach_of_lens<double, double>(dice);
}

}  // namespace parray::test
