#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "common/scene/scene.h"

namespace parray::input {

/// Collects the spheres of many frames that reach farthest, one for each of many directions. A
/// picture that contains these spheres contains the others, except for less than 1 % of the group's
/// radius. Capsules do not count.
class Silhouette {
 public:
  Silhouette();

  /// Adds the spheres of a frame. Takes time in proportion to their number. The result does not
  /// depend on the number of threads.
  void add(std::span<const Sphere> spheres, int threads = 1);
  /// Returns the spheres without repetitions, at most 1024. The order is that of the directions.
  [[nodiscard]] std::vector<Sphere> spheres() const;

 private:
  struct Farthest {
    double reach;  ///< of the sphere along the direction
    Sphere sphere;
  };
  static void add_to(Farthest& farthest, const Vec3d& direction, std::span<const Sphere> spheres);

  std::vector<Vec3d> directions_;  ///< unit vectors
  std::vector<Farthest> farthest_;
};

}  // namespace parray::input
