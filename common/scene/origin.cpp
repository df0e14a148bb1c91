#include "common/scene/origin.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "common/math/largest_component.h"

namespace parray {
namespace {

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// How far from `origin` the camera and half of the spheres lie.
double reach(const Scene& scene, const Vec3d& origin) {
  std::vector<double> distances;
  distances.reserve(scene.spheres.size());
  for (const Sphere& sphere : scene.spheres) {
    distances.push_back(largest_component(sphere.center - origin));
  }
  return std::max(median(std::move(distances)), largest_component(scene.camera.look_from - origin));
}

/// Of all centres, not of some: which ones would depend on the order of the spheres.
double middle_of(const Scene& scene, double Vec3d::*axis) {
  std::vector<double> values;
  values.reserve(scene.spheres.size());
  for (const Sphere& sphere : scene.spheres) {
    values.push_back(sphere.center.*axis);
  }
  return median(std::move(values));
}

}  // namespace

Vec3d scene_origin(const Scene& scene) {
  if (scene.spheres.empty()) {
    return {};
  }
  const Vec3d middle{middle_of(scene, &Vec3d::x), middle_of(scene, &Vec3d::y),
                     middle_of(scene, &Vec3d::z)};
  // By the triangle inequality no scene is four times nearer then, and most end here.
  if (3 * largest_component(scene.camera.look_from - middle) > largest_component(middle)) {
    return {};
  }
  return 4 * reach(scene, middle) <= reach(scene, {}) ? middle : Vec3d{};
}

}  // namespace parray
