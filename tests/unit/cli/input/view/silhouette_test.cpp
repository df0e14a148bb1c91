#include "cli/input/view/silhouette.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <vector>

#include "tests/support/rooms.h"
#include "tests/support/sphere_groups.h"

namespace parray {
namespace {

using test::cloud;

/// How far the spheres reach along a direction.
double reach(const std::vector<Sphere>& spheres, const Vec3d& direction) {
  double reach = -1e300;
  for (const Sphere& sphere : spheres) {
    reach = std::max(reach, dot(direction, sphere.center) + sphere.radius);
  }
  return reach;
}

}  // namespace

TEST_CASE("the silhouette reaches as far as all spheres of all frames, except for one percent") {
  Silhouette silhouette;
  std::vector<Sphere> all;
  for (std::uint64_t frame = 0; frame < 5; ++frame) {
    const std::vector<Sphere> spheres =
        cloud(2000, {1.0 * static_cast<double>(frame), 0, 0}, {10, 8, 6}, 0.3, frame);
    silhouette.add(spheres, 3);
    all.insert(all.end(), spheres.begin(), spheres.end());
  }
  const std::vector<Sphere> few = silhouette.spheres();
  CHECK(few.size() <= 1024);
  const double radius = (reach(all, {1, 0, 0}) + reach(all, {-1, 0, 0})) / 2;
  for (const Sphere& towards : cloud(500, {0, 0, 0}, {1, 1, 1}, 0.1, 99)) {
    const Vec3d direction = normalize(towards.center);
    CHECK(reach(few, direction) >= reach(all, direction) - 0.01 * radius);
  }
}

TEST_CASE("the silhouette reaches as far as the ends of capsules") {
  Silhouette silhouette;
  silhouette.add(std::vector<Sphere>{{{0, 0, 0}, 1, 0}});
  silhouette.add(
      std::vector<Capsule>{{{0, 0, 0}, {5, 0, 0}, 0.5, 0}, {{0, -7, 0}, {0, 0, 0}, 1, 0}});
  const std::vector<Sphere> few = silhouette.spheres();
  CHECK(reach(few, {1, 0, 0}) == 5.5);
  CHECK(reach(few, {-1, 0, 0}) == doctest::Approx(1));
  CHECK(reach(few, {0, -1, 0}) == 8);
}

TEST_CASE("a silhouette contains each sphere once, and none if there are none") {
  Silhouette silhouette;
  CHECK(silhouette.spheres().empty());
  const std::vector<Sphere> two{{{0, 0, 0}, 1, 0}, {{0, 0, 0.5}, 0.1, 0}, {{9, 0, 0}, 1, 0}};
  silhouette.add(two);
  silhouette.add(two);
  CHECK(silhouette.spheres().size() == 2);  // the second is inside the first
}

}  // namespace parray
