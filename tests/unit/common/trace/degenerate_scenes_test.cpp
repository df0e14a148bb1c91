#include <doctest/doctest.h>

#include <array>
#include <cstdint>

#include "common/math/float_mode.h"
#include "common/scene/settings.h"
#include "common/trace/tracer.h"
#include "tests/support/dice.h"
#include "tests/support/precisions.h"
#include "tests/support/rooms.h"
#include "tests/support/tracers.h"

/// Scenes that a careless accelerator divides for ever, or takes memory without bound for.
namespace parray::test {
namespace {

constexpr std::uint32_t many = 5000;
/// Number of spheres of one glass around one point. A path crosses their surfaces one by one, so
/// its time grows with the square. Its six segments suffice to cross so many, but one segment does
/// not.
constexpr std::uint32_t glasses = 2 * trace::most_crossings + 22;

/// Largest memory of any accelerator: the octree's, in double precision: fewer than two cells of
/// 128 bytes a sphere, its shape and its index. A root, where there are no spheres.
constexpr std::size_t most_bytes_a_sphere = 300;
constexpr std::size_t copied_bytes_a_sphere = 4 * sizeof(double) + sizeof(std::uint32_t);
/// Lanes without a sphere take room, too.
constexpr std::size_t most_bytes_a_block = 400;

/// Every accelerator gives the sums of linear search, in bounded memory; `met`: rays meet spheres.
void check_accelerators(const Scene& scene, bool met = true) {
  const FloatMode mode;
  RenderSettings settings;
  settings.width = 8;
  settings.height = 6;
  settings.samples_per_pixel = 1;
  settings.max_depth = 6;
  for (const Precision precision : {Precision::f32, Precision::f64}) {
    CAPTURE(name_of(precision));
    settings.precision = precision;
    settings.accelerator = AcceleratorKind::linear;
    const ReferenceSums expected = sums_of(*make_path_tracer(scene, settings), settings);
    const std::uint64_t samples = std::uint64_t{8} * 6;
    CHECK(expected.counts.samples == samples);
    CHECK(expected.counts.nonfinite == 0);
    CHECK((expected.counts.rays > samples) == met);
    for (const AcceleratorKind accelerator : accelerators) {
      CAPTURE(name_of(accelerator));
      settings.accelerator = accelerator;
      const auto tracer = make_path_tracer(scene, settings);
      const ReferenceSums found = sums_of(*tracer, settings);
      CHECK(found.pixels == expected.pixels);
      CHECK(found.counts.rays == expected.counts.rays);
      // Paths of the octree look up the spheres outside the tree.
      const std::size_t copy = accelerator == AcceleratorKind::octree ? copied_bytes_a_sphere : 0;
      CHECK(tracer->accelerator()->bytes() <=
            (most_bytes_a_sphere + copy) * scene.spheres.size() + most_bytes_a_block);
    }
  }
}

/// A camera at (0, 0, `distance`) that looks at the origin; materials 0 diffuse, 1 metal, 2 glass.
Scene looked_at_from(double distance) {
  Scene scene;
  scene.camera.look_from = {0, 0, distance};
  scene.camera.tan_half_vfov = 0.5;
  scene.camera.aperture = distance / 100;
  scene.camera.focus_distance = distance;
  scene.materials = {{MaterialType::diffuse, {0.5, 0.6, 0.7}, 0, 1},
                     {MaterialType::metal, {0.9, 0.8, 0.7}, 0.1, 1},
                     {MaterialType::dielectric, {1, 1, 1}, 0, 1.5}};
  return scene;
}

Sphere at(const Vec3d& center, double radius, std::uint32_t number) {
  return {center, radius, number % 3};
}

}  // namespace

TEST_CASE("thousands of spheres in one place are traced alike by all accelerators") {
  for (const std::uint32_t material : {0U, 1U, 2U}) {
    CAPTURE(material);
    Scene scene = looked_at_from(4);
    scene.spheres.assign(material == 2 ? glasses : many, {{0.1, 0.2, 0.3}, 1, material});
    check_accelerators(scene);
  }
}

TEST_CASE("thousands of concentric spheres are traced alike by all accelerators") {
  Dice dice(1);
  Scene scene = looked_at_from(4);
  for (std::uint32_t i = 0; i < many; ++i) {
    scene.spheres.push_back(at({0.1, 0.2, 0.3}, dice.ten_to(-3, 0), i));
  }
  check_accelerators(scene);
}

TEST_CASE("thousands of spheres in a row are traced alike by all accelerators") {
  const std::array<Vec3d, 3> ways{Vec3d{1, 0, 0}, Vec3d{1, 1, -1}, Vec3d{0.3, -0.2, 1}};
  for (const Vec3d& way : ways) {
    CAPTURE(way.z);
    Scene scene = looked_at_from(5);
    for (std::uint32_t i = 0; i < many; ++i) {
      scene.spheres.push_back(at((i - many / 2.0) * way, 0.4, i));
    }
    check_accelerators(scene);
  }
}

TEST_CASE("chains of touching spheres are traced alike by all accelerators") {
  Scene scene = looked_at_from(20);
  for (std::uint32_t i = 0; i < many / 2; ++i) {  // along an axis, through the look
    scene.spheres.push_back(at({0, 0, -1.0 * i}, 0.5, i));
  }
  double x = 0;
  double radius = 4;
  for (int i = 0; i < 130; ++i) {  // each touches the last, ever smaller, down to 1e-12
    scene.spheres.push_back(at({x, 3, 0}, radius, 1));
    x += radius * 1.8;
    radius *= 0.8;
  }
  check_accelerators(scene);
}

TEST_CASE("radii from a thousandth to a million are traced alike by all accelerators") {
  Dice dice(2);
  Scene scene = looked_at_from(40);
  for (int x = 0; x < 10; ++x) {
    for (int y = 0; y < 10; ++y) {
      for (int z = 0; z < 10; ++z) {
        const double radius = dice.ten_to(-3, 0);
        scene.spheres.push_back(at({x - 4.5, y - 4.5, z - 4.5}, radius, dice.below32(3)));
      }
    }
  }
  for (const double radius : {1e2, 1e3, 1e4, 1e5, 1e6}) {  // floors, one behind the other
    scene.spheres.push_back(at({0, -8 - radius * 1.001, 0}, radius, 0));
  }
  check_accelerators(scene);
}

TEST_CASE("no spheres and one sphere are traced alike by all accelerators") {
  Scene scene = looked_at_from(3);
  check_accelerators(scene, false);
  for (const std::uint32_t material : {0U, 1U, 2U}) {
    scene.spheres = {{{0, 0, 0}, 1, material}};
    check_accelerators(scene);
  }
}

TEST_CASE("a camera inside of hundreds of spheres sees the same with all accelerators") {
  Dice dice(3);
  Scene scene = looked_at_from(1);
  for (std::uint32_t i = 0; i < glasses; ++i) {
    scene.spheres.push_back(at(0.5 * dice.direction(), 2 + dice.unit(), 2));
    scene.spheres.push_back(at(scene.camera.look_from, 3 + dice.unit(), i));
  }
  scene.camera.aperture = 3;  // and of some with a part of its lens only
  check_accelerators(scene);
}

}  // namespace parray::test
