#include "cli/input/view/silhouette.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "cli/input/scene_file/duplicates.h"
#include "common/base/bands.h"

namespace parray::input {
namespace {

/// Returns 1024 unit vectors that cover the sphere evenly. Neighbours are about 6 degrees apart.
/// Source: the spherical Fibonacci lattice (Gonzalez, "Measurement of areas on a sphere using
/// Fibonacci and latitude-longitude lattices", Mathematical Geosciences 42, 2010).
std::vector<Vec3d> even_directions() {
  constexpr int count = 1024;
  std::vector<Vec3d> directions;
  for (int i = 0; i < count; ++i) {
    const double z = 1 - (2.0 * i + 1) / count;
    const double angle = 2 * std::numbers::pi * i / std::numbers::phi;
    const double radius = std::sqrt(1 - z * z);
    directions.push_back({radius * std::cos(angle), radius * std::sin(angle), z});
  }
  return directions;
}

double reach_of(const Sphere& sphere, const Vec3d& direction) {
  return dot(direction, sphere.center) + sphere.radius;
}
double reach_of(const Capsule& capsule, const Vec3d& direction) {
  return std::max(dot(direction, capsule.from), dot(direction, capsule.to)) + capsule.radius;
}

/// Returns the sphere at the end of a shape that reaches farthest in a direction.
Sphere end_of(const Sphere& sphere, const Vec3d& /*direction*/) { return sphere; }
Sphere end_of(const Capsule& capsule, const Vec3d& direction) {
  const bool to = dot(direction, capsule.to) > dot(direction, capsule.from);
  return {to ? capsule.to : capsule.from, capsule.radius, capsule.material};
}

}  // namespace

Silhouette::Silhouette()
    : directions_(even_directions()),
      farthest_(directions_.size(), {-std::numeric_limits<double>::infinity(), {}}) {}

template <typename Shape>
void Silhouette::add_all(std::span<const Shape> shapes, int threads) {
  Bands(directions_.size(), threads)
      .run([&](std::size_t /*band*/, std::size_t begin, std::size_t end) {
        constexpr std::size_t cached = 512;  // shapes that stay in the cache
        for (std::size_t first = 0; first < shapes.size(); first += cached) {
          const auto some = shapes.subspan(first, std::min(cached, shapes.size() - first));
          for (std::size_t i = begin; i < end; ++i) {
            for (const Shape& shape : some) {
              const double reach = reach_of(shape, directions_[i]);
              if (reach > farthest_[i].reach) farthest_[i] = {reach, end_of(shape, directions_[i])};
            }
          }
        }
      });
}

template void Silhouette::add_all(std::span<const Sphere>, int);
template void Silhouette::add_all(std::span<const Capsule>, int);

std::vector<Sphere> Silhouette::spheres() const {
  std::vector<Sphere> spheres;
  for (const Farthest& farthest : farthest_) {
    const bool none = farthest.reach == -std::numeric_limits<double>::infinity();
    const bool known = std::ranges::any_of(
        spheres, [&](const Sphere& sphere) { return same_place(sphere, farthest.sphere); });
    if (!none && !known) spheres.push_back(farthest.sphere);
  }
  return spheres;
}

}  // namespace parray::input
