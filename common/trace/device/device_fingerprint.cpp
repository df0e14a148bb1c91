#include "common/trace/device/device_fingerprint.h"

#include <array>
#include <cstdint>
#include <vector>

#include "common/base/sha256.h"
#include "common/scene/settings.h"

namespace parray::trace {
namespace {

Scene scene_with_materials() {
  Scene scene;
  scene.camera.tan_half_vfov = 0.25;
  scene.materials = {{MaterialType::diffuse, {0.5, 0.6, 0.7}, 0, 1},
                     {MaterialType::metal, {0.9, 0.8, 0.7}, 0.3, 1},
                     {MaterialType::dielectric, {1, 1, 1}, 0, 1.5},
                     {MaterialType::metal, {0.8, 0.9, 0.6}, 0, 1},
                     {MaterialType::dielectric, {1, 1, 1}, 0, 1 / 1.5}};
  return scene;
}

/// Shapes of all sizes, each about as large as it looks from the eye.
Scene sizes() {
  Scene scene = scene_with_materials();
  scene.camera.look_from = {};
  scene.camera.look_at = {0, 0, -1};
  scene.camera.aperture = 0;
  scene.camera.tan_half_vfov = 1;
  double radius = 1 / 1e15;
  for (std::uint32_t i = 0; i < 61; ++i) {
    const Vec3d center = 8 * radius * Vec3d{0.4 * (i % 5) - 0.8, 0.4 * (i % 4) - 0.6, -1};
    if (i % 3 == 2) {
      scene.capsules.push_back({center, center + radius * Vec3d{3, 1, 2}, radius, i % 5});
    } else {
      scene.spheres.push_back({center, radius, i % 5});
    }
    radius *= 3.1622776601683795;
  }
  return scene;
}

/// Shapes that coincide or touch, in a regular lattice: many crossings are equally far.
Scene ties() {
  Scene scene = scene_with_materials();
  scene.camera.look_from = {8, 2, 6};
  scene.camera.look_at = {1.5, 0.5, 1.5};
  scene.camera.aperture = 0;
  for (std::uint32_t i = 0; i < 64; ++i) {
    const std::uint32_t layer = i / 16;
    const Vec3d center{1.0 * (i % 4), 1.0 * (i / 4 % 4) - 1, 1.0 * layer};
    scene.spheres.push_back({center, 0.5, i % 5});
    if (i % 2 == 0) scene.spheres.push_back({center, 0.5, (i + 2) % 5});
    if (i % 3 == 0) scene.capsules.push_back({center, center, 0.5, (i + 1) % 5});
    if (i % 5 == 0) scene.capsules.push_back({center, center + Vec3d{0, 1, 0}, 0.5, (i + 3) % 5});
  }
  return scene;
}

/// Positions whose squares are denormal in single precision, albedos that make light denormal, and
/// a sky as dark as the smallest numbers.
Scene denormals() {
  Scene scene = scene_with_materials();
  constexpr double dark = 1 / 1e39;
  constexpr double small = 1 / 1e20;
  scene.sky = {dark * Vec3d{3, 1, 0.2}, dark * Vec3d{10, 5, 0.07}};
  scene.materials[0].albedo = {1 / 1e5, 1 / 1e6, 0.9};
  scene.materials[1].albedo = {0.7, 1 / 1e3, 1 / 1e4};
  scene.camera.look_from = small * Vec3d{8, 2, 6};
  scene.camera.look_at = {};
  scene.camera.aperture = 0.1 * small;
  scene.camera.focus_distance = 10 * small;
  for (std::uint32_t i = 0; i < 27; ++i) {
    const std::uint32_t layer = i / 9;
    const Vec3d center = small * Vec3d{1.0 * (i % 3), 1.0 * (i / 3 % 3), 1.0 * layer};
    scene.spheres.push_back({center, 0.6 * small, i % 5});
    if (i % 4 == 0) {
      scene.capsules.push_back({center, center + small * Vec3d{0.5, 1, 0.25}, 0.3 * small, i % 5});
    }
  }
  return scene;
}

/// Overlapping bodies of glass around an orthographic camera with a lens, and a large ground.
Scene glass() {
  Scene scene = scene_with_materials();
  scene.camera.projection = Projection::orthographic;
  scene.camera.view_height = 4;
  scene.camera.tan_half_vfov = 0;
  scene.camera.look_from = {2, 1.5, 2};
  scene.camera.aperture = 0.3;
  scene.camera.focus_distance = 3;
  scene.spheres = {{{0, -1e6, 0}, 1e6, 0}, {{0, 1, 0}, 1.5, 2}, {{0, 1, 0}, 1.25, 4}};
  for (std::uint32_t i = 0; i < 48; ++i) {
    const std::uint32_t row = i / 8;
    const Vec3d center{0.5 * (i % 8) - 1.75, 0.25 * (i % 5), 0.5 * row - 1.5};
    scene.spheres.push_back({center, 0.375, i % 4 == 0 ? 1U : 2U});
    scene.capsules.push_back({center, center + Vec3d{0.5, 0.3, 0.1}, 0.2, i % 7 == 0 ? 3U : 2U});
  }
  return scene;
}

}  // namespace

std::string device_fingerprint(const PictureTracer& trace) {
  const std::array scenes{sizes(), ties(), denormals(), glass()};
  RenderSettings settings;
  settings.width = 60;
  settings.height = 28;
  settings.samples_per_pixel = 5;
  settings.max_depth = 12;
  std::vector<std::uint64_t> found;
  for (std::size_t i = 0; i < scenes.size(); ++i) {
    for (const Precision precision : {Precision::f32, Precision::mixed, Precision::f64}) {
      settings.precision = precision;
      settings.sampler = i % 2 == 0 ? Sampler::sobol : Sampler::independent;
      settings.accelerator = i == 0 ? AcceleratorKind::linear : AcceleratorKind::bvh;
      std::vector<PixelSums> pixels(std::size_t{settings.width} * settings.height);
      TraceCounts counts;
      trace(scenes[i], settings, pixels, counts);
      for (const PixelSums& pixel : pixels) {
        for (std::size_t channel = 0; channel < 3; ++channel) {
          found.push_back(pixel.sum[channel]);
          found.push_back(pixel.sum_of_squares[channel]);
          found.push_back(pixel.odd[channel]);
        }
      }
      found.insert(found.end(), {counts.samples, counts.rays, counts.nonfinite, counts.lost});
    }
  }
  return sha256_hex(std::as_bytes(std::span(found)));
}

}  // namespace parray::trace
