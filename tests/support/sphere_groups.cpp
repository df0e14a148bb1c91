#include "tests/support/sphere_groups.h"

#include <cmath>
#include <random>
#include <utility>

#include "tests/support/rooms.h"

namespace parray::test {

std::vector<Sphere> cloud(std::size_t count, const Vec3d& center, const Vec3d& size, double radius,
                          std::uint64_t seed) {
  std::mt19937_64 random(seed);
  const auto uniform = [&] { return std::uniform_real_distribution<>(-0.5, 0.5)(random); };
  std::vector<Sphere> spheres;
  for (std::size_t i = 0; i < count; ++i) {
    const Vec3d offset{uniform(), uniform(), uniform()};
    spheres.push_back({center + size * offset, radius * (0.75 + 0.5 * uniform()), 0});
  }
  return spheres;
}

std::vector<Group> sphere_groups() {
  std::vector<Group> all = {
      {"one", {{{1, 2, 3}, 1.5, 0}}},
      {"one at the origin", {{{0, 0, 0}, 1, 0}}},
      {"three at one place", {{{4, 5, 6}, 1, 0}, {{4, 5, 6}, 2, 0}, {{4, 5, 6}, 1, 0}}},
      {"two", {{{0, 0, 0}, 1, 0}, {{0, 3, 0}, 0.25, 0}}},
      {"a ball", cloud(1000, {0, 0, 0}, {1, 1, 1}, 0.05, 1)},
      {"a slab", cloud(1000, {7, -8, 9}, {20, 2, 30}, 1, 2)},
      {"a rod", cloud(500, {0, 50, 0}, {1, 1, 90}, 0.3, 3)},
      {"a plane", cloud(300, {0, 0, 5}, {30, 20, 0}, 0.5, 4)},
      {"tiny", cloud(50, {0, 0, 0}, {1e-9, 3e-9, 2e-9}, 1e-10, 5)},
      {"vast", cloud(50, {0, 0, 0}, {1e9, 3e9, 2e9}, 1e8, 6)},
      {"far away", cloud(50, {1e6, -1e6, 1e6}, {1, 3, 2}, 0.1, 7)},
      {"points, nearly", cloud(50, {0, 0, 0}, {1, 3, 2}, 1e-12, 8)},
      {"a giant among dwarfs", {{{0, 0, 0}, 1e-3, 0}, {{1, 0, 0}, 1e3, 0}, {{5, 1, 0}, 1e-3, 0}}}};
  Group line{"a line", {}};
  Group lattice{"a lattice", {}};
  for (int i = 0; i < 125; ++i) {
    line.spheres.push_back({{1.0 * i, 2.0 * i, -1.0 * i}, 0.5, 0});
    const int layer = i / 25;
    lattice.spheres.push_back({{1.0 * (i % 5), 1.0 * (i / 5 % 5), 1.0 * layer}, 0.5, 0});
  }
  all.push_back(std::move(line));
  all.push_back(std::move(lattice));
  return all;
}

std::vector<Sphere> scaled(std::vector<Sphere> spheres, double factor) {
  for (Sphere& sphere : spheres) {
    sphere.center = factor * sphere.center;
    sphere.radius *= factor;
  }
  return spheres;
}

Film::Film(const Camera& camera, double aspect)
    : eye(camera.look_from),
      back(normalize(camera.look_from - camera.look_at)),
      right(normalize(cross(camera.up, back))),
      up(cross(back, right)),
      parallel(camera.projection == Projection::orthographic),
      half_height(parallel ? camera.view_height / 2 : camera.tan_half_vfov) {
  half_width = half_height * aspect;
}

double Film::inside(const Sphere& sphere, double x, double y) const {
  const Vec3d p = sphere.center - eye;
  const double reach = std::abs(x) * half_width + std::abs(y) * half_height;
  const Vec3d side = x * right + y * up;
  if (parallel) return (reach - dot(p, side)) / sphere.radius;
  const Vec3d normal = side + reach * back;
  return -dot(p, normal) / length(normal) / sphere.radius;
}

Vec3d Film::origin(double x, double y) const {
  return parallel ? eye + (x * half_width) * right + (y * half_height) * up : eye;
}

Vec3d Film::ray(double x, double y) const {
  return parallel ? -back : normalize((x * half_width) * right + (y * half_height) * up - back);
}

bool Film::hits(double x, double y, const Sphere& sphere) const {
  const Vec3d to_center = sphere.center - origin(x, y);
  const Vec3d direction = ray(x, y);
  const double along = dot(to_center, direction);
  return along > 0 && length(to_center - along * direction) < sphere.radius;
}

}  // namespace parray::test
