#include "tests/bench/bench_scenes.h"

#include <array>
#include <cmath>
#include <numbers>
#include <string>

#include "cli/input/scene_file/scene_file.h"
#include "cli/input/scene_file/scene_sections.h"
#include "common/math/philox.h"
#include "tests/support/rooms.h"

namespace parray::bench {
namespace {

constexpr std::uint32_t diffuse_kinds = 40;
constexpr std::uint32_t metal_kinds = 8;
constexpr std::uint32_t glass_kinds = 2;
constexpr double volume_fraction = 0.1;

/// Streams of random numbers.
enum Stream : std::uint32_t { colours, positions, sizes };

/// Vec4 uniform numbers in [0, 1), a function of (stream, item, block) alone.
std::array<double, 4> draw(Stream stream, std::uint32_t item, std::uint32_t block = 0) {
  const auto bits = philox4x32<std::uint32_t>({item, block, 0, 0}, {stream, 0});
  return {bits.a * 0x1p-32, bits.b * 0x1p-32, bits.c * 0x1p-32, bits.d * 0x1p-32};
}

/// Uniform in the unit ball: the first of a row of points in its cube that lies inside.
Vec3d point_in_ball(std::uint32_t item) {
  for (std::uint32_t block = 0;; ++block) {
    const auto u = draw(positions, item, block);
    const Vec3d point{2 * u[0] - 1, 2 * u[1] - 1, 2 * u[2] - 1};
    if (dot(point, point) <= 1) return point;
  }
}

/// Distributed as the One Weekend scene's.
std::vector<Material> cloud_materials() {
  std::vector<Material> materials;
  for (std::uint32_t i = 0; i < diffuse_kinds; ++i) {
    const auto a = draw(colours, i);
    const auto b = draw(colours, i, 1);
    materials.push_back({MaterialType::diffuse, {a[0] * b[0], a[1] * b[1], a[2] * b[2]}, 0, 1});
  }
  for (std::uint32_t i = 0; i < metal_kinds; ++i) {
    const auto u = draw(colours, diffuse_kinds + i);
    materials.push_back({MaterialType::metal,
                         {0.5 + 0.5 * u[0], 0.5 + 0.5 * u[1], 0.5 + 0.5 * u[2]},
                         0.5 * u[3],
                         1});
  }
  for (std::uint32_t i = 0; i < glass_kinds; ++i) {
    materials.push_back({MaterialType::dielectric, {1, 1, 1}, 0, 1.3 + 0.2 * i});
  }
  return materials;
}

std::uint32_t cloud_material(double kind, double which) {
  const auto among = [which](std::uint32_t first, std::uint32_t count) {
    return first + static_cast<std::uint32_t>(which * count);
  };
  if (kind < 0.80) return among(0, diffuse_kinds);
  return kind < 0.95 ? among(diffuse_kinds, metal_kinds)
                     : among(diffuse_kinds + metal_kinds, glass_kinds);
}

Camera cloud_camera() {
  Camera camera;
  camera.look_from = {2.6, 1.0, 2.0};
  camera.look_at = {0, 0, 0};
  camera.vfov = 35;  // the unit ball at this distance fills 33.8 degrees
  camera.aperture = 0;
  camera.focus_distance = 3;
  camera.tan_half_vfov = tan_half_of(camera.vfov);
  return camera;
}

}  // namespace

Scene cloud(std::uint32_t count) {
  Scene scene;
  scene.camera = cloud_camera();
  scene.materials = cloud_materials();
  scene.spheres.reserve(count);
  // Radii are uniform in [2/3, 4/3] of `middle`: the mean of their cubes is 10/9 of middle^3.
  const double middle = std::cbrt(volume_fraction / (10.0 / 9.0 * count));
  for (std::uint32_t i = 0; i < count; ++i) {
    const auto u = draw(sizes, i);
    scene.spheres.push_back(
        {point_in_ball(i), middle * (2 + 2 * u[0]) / 3, cloud_material(u[1], u[2])});
  }
  return scene;
}

Scene sticks(std::uint32_t count) {
  constexpr double stick_fraction = 0.05;
  constexpr double length = 6;  // radii
  Scene scene;
  scene.camera = cloud_camera();
  scene.materials = cloud_materials();
  // A stick of radius 1 has this volume, in volumes of a unit ball: its cylinder and its two ends.
  const double volume = 0.75 * length + 1;
  const double radius = std::cbrt(stick_fraction / (volume * count));
  for (std::uint32_t i = 0; i < count; ++i) {
    const auto u = draw(sizes, i);
    const auto direction = draw(sizes, i, 1);
    const double z = 2 * direction[0] - 1;
    const double around = 2 * std::numbers::pi * direction[1];
    const double flat = std::sqrt(1 - z * z);
    const Vec3d along{flat * std::cos(around), flat * std::sin(around), z};
    const Vec3d middle = point_in_ball(i);
    const double half = length * radius / 2;
    scene.capsules.push_back(
        {middle - half * along, middle + half * along, radius, cloud_material(0.95 * u[1], u[2])});
  }
  return scene;
}

Scene scene_of_size(std::uint32_t count, const std::filesystem::path& folder) {
  return count >= smallest_cloud
             ? cloud(count)
             : read_scene_file(folder / ("one-weekend-" + std::to_string(count) + ".json")).scene;
}

}  // namespace parray::bench
