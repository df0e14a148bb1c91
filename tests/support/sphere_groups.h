#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "common/scene/scene.h"
#include "tests/support/rooms.h"

/// Groups of spheres of all kinds, and how cameras see them.
namespace parray::test {

struct Group {
  std::string name;
  std::vector<Sphere> spheres;
};

/// Centres uniform in a box around `center`, radii up to `radius`.
std::vector<Sphere> cloud(std::size_t count, const Vec3d& center, const Vec3d& size, double radius,
                          std::uint64_t seed);
/// Of one sphere and of many, in line, plane and space, near and far, large and small; the last is
/// a lattice.
std::vector<Group> sphere_groups();
std::vector<Sphere> scaled(std::vector<Sphere> spheres, double factor);

/// The view's axes, as common/trace/integrator/camera_rays.h has them, and how far the film
/// reaches: at distance 1, or everywhere if the camera is orthographic.
struct Film {
  Film(const Camera& camera, double aspect);

  /// How far, in radii, a sphere stays inside the picture's edge at the side whose normal in the
  /// picture is (x, y): >= 1 is all inside, <= -1 all outside.
  [[nodiscard]] double inside(const Sphere& sphere, double x, double y) const;
  /// Where the ray through a point of the picture begins, and where it goes; x and y from -1 to 1.
  [[nodiscard]] Vec3d origin(double x, double y) const;
  [[nodiscard]] Vec3d ray(double x, double y) const;
  [[nodiscard]] bool hits(double x, double y, const Sphere& sphere) const;

  Vec3d eye, back, right, up;
  bool parallel;
  double half_width, half_height;
};

}  // namespace parray::test
