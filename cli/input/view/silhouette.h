#pragma once

#include <span>
#include <vector>

#include "common/scene/scene.h"

namespace parray::input {

/// Collects the shapes of many frames that reach farthest, one for each of 1024 directions. A
/// capsule counts as two spheres at its ends. A picture that contains the collected spheres
/// contains all shapes, except for less than 1 % of the group's radius.
class Silhouette {
 public:
  Silhouette();

  /// Add the spheres or the capsules of a frame. Take time in proportion to their number. The
  /// result does not depend on the number of threads.
  void add(std::span<const Sphere> spheres, int threads = 1) { add_all(spheres, threads); }
  void add(std::span<const Capsule> capsules, int threads = 1) { add_all(capsules, threads); }
  /// Returns the spheres without repetitions, at most 1024. The order is that of the directions.
  [[nodiscard]] std::vector<Sphere> spheres() const;

 private:
  struct Farthest {
    double reach;  ///< of the sphere along the direction
    Sphere sphere;
  };
  template <typename Shape>
  void add_all(std::span<const Shape> shapes, int threads);

  std::vector<Vec3d> directions_;  ///< unit vectors
  std::vector<Farthest> farthest_;
};

}  // namespace parray::input
