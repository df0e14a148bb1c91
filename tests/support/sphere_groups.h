#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "common/scene/scene.h"
#include "tests/support/rooms.h"

/// Groups of spheres of all kinds, and their place in a camera's picture.
namespace parray::test {

struct Group {
  std::string name;
  std::vector<Sphere> spheres;
};

/// Makes spheres with uniform centres in a box around `center` and radii up to `radius`.
std::vector<Sphere> cloud(std::size_t count, const Vec3d& center, const Vec3d& size, double radius,
                          std::uint64_t seed);
/// Returns groups of one sphere and of many, in a line, a plane and space, near and far, large and
/// small. The last is a lattice.
std::vector<Group> sphere_groups();
std::vector<Sphere> scaled(std::vector<Sphere> spheres, double factor);

/// The axes of the view, as in common/trace/integrator/camera_rays.h, and half the size of the
/// film: at distance 1 or, for an orthographic camera, at every distance.
struct Film {
  Film(const Camera& camera, double aspect);

  /// Returns how far, in radii, a sphere's centre is inside the edge of the picture that has the
  /// normal (x, y). From 1 on the sphere is completely inside, from -1 down completely outside.
  [[nodiscard]] double inside(const Sphere& sphere, double x, double y) const;
  /// Return origin and direction of the ray through a point of the picture; x and y from -1 to 1.
  [[nodiscard]] Vec3d origin(double x, double y) const;
  [[nodiscard]] Vec3d ray(double x, double y) const;
  [[nodiscard]] bool hits(double x, double y, const Sphere& sphere) const;

  Vec3d eye, back, right, up;
  bool parallel;
  double half_width, half_height;
};

}  // namespace parray::test
