#include "cli/check/doctor/known_pictures.h"

#include <algorithm>
#include <cmath>

#include "common/image/radiance_scale.h"
#include "common/scene/settings.h"

namespace parray::doctor {

RenderSettings sized(std::uint32_t width, std::uint32_t height, std::uint64_t samples,
                     std::uint32_t depth) {
  RenderSettings settings;
  settings.width = width;
  settings.height = height;
  settings.samples_per_pixel =
      static_cast<std::uint32_t>(std::min<std::uint64_t>(samples, 1U << 24));
  settings.max_depth = depth;
  return settings;
}

Scene under_white_sky() {
  Scene scene;
  scene.sky = {{1, 1, 1}, {1, 1, 1}};
  scene.camera.aperture = 0;
  scene.camera.tan_half_vfov = 0.5;
  return scene;
}

Scene white_balls() {
  Scene scene = under_white_sky();
  scene.camera.look_from = {0, 0, 6};
  scene.camera.tan_half_vfov = 0.4;
  scene.materials = {{MaterialType::diffuse, {1, 1, 1}, 0, 1},
                     {MaterialType::metal, {1, 1, 1}, 0, 1},
                     {MaterialType::dielectric, {1, 1, 1}, 0, 1.5},
                     {MaterialType::dielectric, {1, 1, 1}, 0, 1 / 1.5}};
  scene.spheres = {
      {{-1, 0, 0}, 1, 0}, {{1, 0, 0}, 1, 1}, {{0, 1.75, 0}, 1, 2}, {{0, 1.75, 0}, 0.875, 3}};
  return scene;
}

Scene closed_ball(double radius, double off_centre) {
  Scene scene = under_white_sky();
  scene.camera.look_from = {off_centre * radius, 0, 0};
  scene.camera.look_at = {-radius, -0.3 * radius, 0.2 * radius};
  scene.materials = {{MaterialType::diffuse, {1, 1, 1}, 0, 1}};
  scene.spheres = {{{0, 0, 0}, radius, 0}};
  return scene;
}

Scene grey_ball(double radius) {
  Scene scene = under_white_sky();
  scene.camera.look_from = {0, 0, 3 * radius};
  scene.camera.tan_half_vfov = 0.2;
  scene.materials = {{MaterialType::diffuse, {0.5, 0.5, 0.5}, 0, 1}};
  scene.spheres = {{{0, 0, 0}, radius, 0}};
  return scene;
}

Scene scaled(Scene scene, int k) {
  const auto by = [k](const Vec3d& v) {
    return Vec3d{std::ldexp(v.x, k), std::ldexp(v.y, k), std::ldexp(v.z, k)};
  };
  scene.camera.look_from = by(scene.camera.look_from);
  scene.camera.look_at = by(scene.camera.look_at);
  scene.camera.aperture = std::ldexp(scene.camera.aperture, k);
  scene.camera.focus_distance = std::ldexp(scene.camera.focus_distance, k);
  for (Sphere& sphere : scene.spheres) {
    sphere.center = by(sphere.center);
    sphere.radius = std::ldexp(sphere.radius, k);
  }
  return scene;
}

std::size_t pixels_other_than(const std::vector<PixelSums>& pixels, std::uint64_t fixed,
                              std::uint64_t samples) {
  PixelSums expected;
  expected.sum.fill(samples * fixed);
  expected.sum_of_squares.fill(samples * RadianceScale::square_of(fixed));
  expected.odd.fill(samples / 2 * fixed);
  return static_cast<std::size_t>(
      std::ranges::count_if(pixels, [&](const PixelSums& pixel) { return !(pixel == expected); }));
}

}  // namespace parray::doctor
