#include <doctest/doctest.h>

#include "cli/input/view/view.h"
#include "tests/support/near.h"
#include "tests/support/rooms.h"

namespace parray {
namespace {

using test::near;

constexpr TurnAxis upright{{1, 2, 3}, {0, 0, 1}};

}  // namespace

TEST_CASE("a turn moves points counter-clockwise around the axis") {
  CHECK(near(turned(Vec3d{2, 2, 7}, upright, 90), {1, 3, 7}));
  CHECK(near(turned(Vec3d{2, 2, 7}, upright, 180), {0, 2, 7}));
  CHECK(near(turned(Vec3d{2, 2, 7}, upright, -90), {1, 1, 7}));
  CHECK(near(turned(Vec3d{1, 2, 9}, upright, 77), {1, 2, 9}));
}

TEST_CASE("whole turns change no bit") {
  Camera camera;
  camera.look_from = {0.1, 0.2, 0.3};
  camera.look_at = {1, 1, 1};
  camera.up = {0, 0.6, 0.8};
  for (const double degrees : {0.0, 360.0, -720.0}) {
    CHECK(turned(camera.look_from, upright, degrees) == camera.look_from);
    CHECK(turned(camera, upright, degrees).up == camera.up);
  }
}

TEST_CASE("a turned camera keeps its distance, its target's height and its tilt") {
  Camera camera;
  camera.look_from = {5, 2, 4};
  camera.look_at = {1, 2, 3.5};
  camera.up = {-0.6, 0, 0.8};
  const Camera other = turned(camera, upright, 120);
  CHECK(length(other.look_from - other.look_at) ==
        doctest::Approx(length(camera.look_from - camera.look_at)));
  CHECK(near(other.look_at, camera.look_at));  // it lies on the axis
  CHECK(other.up.z == doctest::Approx(0.8));
  CHECK(near(turned(other, upright, 240).look_from, camera.look_from));
}

TEST_CASE("the axis of a camera goes through its target along its upward direction") {
  Camera camera;
  camera.look_at = {3, 4, 5};
  camera.up = {0, 2, 0};
  CHECK(axis_of(camera).point == Vec3d{3, 4, 5});
  CHECK(axis_of(camera).up == Vec3d{0, 1, 0});
}

}  // namespace parray
