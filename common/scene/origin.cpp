#include "common/scene/origin.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace parray {
namespace {

/// A sample of the spheres' centres says enough about where most of them lie.
constexpr std::size_t sample_size = 1023;

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

double largest_component(const Vec3d& v) {
  return std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)});
}

/// How far from `origin` the camera and half of the spheres lie.
double reach(const std::vector<Vec3d>& centers, const Vec3d& camera, const Vec3d& origin) {
  std::vector<double> distances;
  distances.reserve(centers.size());
  for (const Vec3d& center : centers) {
    distances.push_back(largest_component(center - origin));
  }
  return std::max(median(distances), largest_component(camera - origin));
}

}  // namespace

Vec3d scene_origin(const Scene& scene) {
  if (scene.spheres.empty()) {
    return {};
  }
  std::vector<Vec3d> centers;
  const std::size_t step = scene.spheres.size() / sample_size + 1;
  for (std::size_t i = 0; i < scene.spheres.size(); i += step) {
    centers.push_back(scene.spheres[i].center);
  }
  std::vector<double> x;
  std::vector<double> y;
  std::vector<double> z;
  for (const Vec3d& center : centers) {
    x.push_back(center.x);
    y.push_back(center.y);
    z.push_back(center.z);
  }
  const Vec3d middle{median(std::move(x)), median(std::move(y)), median(std::move(z))};
  const Vec3d& camera = scene.camera.look_from;
  return 4 * reach(centers, camera, middle) <= reach(centers, camera, {}) ? middle : Vec3d{};
}

}  // namespace parray
