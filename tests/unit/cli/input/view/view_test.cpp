#include "cli/input/view/view.h"

#include <doctest/doctest.h>

#include <cmath>
#include <string>
#include <vector>

#include "cli/input/view/surroundings.h"
#include "common/base/error.h"
#include "tests/support/message_of.h"
#include "tests/support/rooms.h"
#include "tests/support/sphere_groups.h"

/// Views of automatic scenes.
namespace parray {
namespace {

using test::cloud;
using test::message_of;

/// A sheet of nx x ny centres, one apart, along two axes.
std::vector<Sphere> sheet(int nx, int ny, const Vec3d& across, const Vec3d& along) {
  std::vector<Sphere> spheres;
  for (int i = 0; i < nx * ny; ++i) {
    const double u = i % nx;
    const int row = i / nx;
    spheres.push_back({Vec3d{3, 4, 5} + u * across + (1.0 * row) * along, 0.5, 0});
  }
  return spheres;
}

bool near(const Vec3d& a, const Vec3d& b) { return length(a - b) < 1e-12; }

}  // namespace

TEST_CASE("the axes of every view are those that it promises") {
  const auto axes = [](View view, const Vec3d& right, const Vec3d& up, const Vec3d& back) {
    CAPTURE(name_of(view));
    const Axes frame = axes_of(view);
    CHECK(frame.right == right);
    CHECK(frame.up == up);
    CHECK(frame.back == back);
  };
  axes(View::front, {1, 0, 0}, {0, 0, 1}, {0, -1, 0});
  axes(View::back, {-1, 0, 0}, {0, 0, 1}, {0, 1, 0});
  axes(View::left, {0, -1, 0}, {0, 0, 1}, {-1, 0, 0});
  axes(View::right, {0, 1, 0}, {0, 0, 1}, {1, 0, 0});
  axes(View::top, {1, 0, 0}, {0, 1, 0}, {0, 0, 1});
  axes(View::bottom, {-1, 0, 0}, {0, 1, 0}, {0, 0, -1});
  const Axes iso = axes_of(View::iso);
  CHECK(near(iso.back, normalize(Vec3d{1, -1, 1})));
  CHECK(iso.up.z > 0.8);
  CHECK(std::abs(iso.right.z) == 0);
  CHECK(iso.right.x > 0);
  for (const View view :
       {View::front, View::back, View::left, View::right, View::top, View::bottom, View::iso}) {
    const Axes frame = axes_of(view);
    CHECK(near(cross(frame.right, frame.up), frame.back));
  }
}

TEST_CASE("cameras of views look along their axes for any particles") {
  const std::vector<Sphere> spheres = cloud(200, {7, -8, 9}, {5, 2, 9}, 0.3, 3);
  for (const View view :
       {View::front, View::back, View::left, View::right, View::top, View::bottom, View::iso}) {
    CAPTURE(name_of(view));
    const Axes axes = axes_of(view);
    const Camera camera = surroundings_of(spheres, 1.5, {.view = view}).camera;
    CHECK(camera.projection == Projection::orthographic);
    CHECK(near(normalize(camera.look_from - camera.look_at), axes.back));
    CHECK(camera.up == axes.up);
    CHECK(surroundings_of(spheres, 1.5, {.view = view, .projection = Projection::perspective})
              .camera.projection == Projection::perspective);
  }
  CHECK(surroundings_of(spheres, 1.5).camera.projection == Projection::perspective);
}

TEST_CASE("an axis as the name of a view is the axis that points at the viewer") {
  CHECK(axes_of(view_from("+x")).back == Vec3d{1, 0, 0});
  CHECK(axes_of(view_from("-x")).back == Vec3d{-1, 0, 0});
  CHECK(axes_of(view_from("+y")).back == Vec3d{0, 1, 0});
  CHECK(axes_of(view_from("-y")).back == Vec3d{0, -1, 0});
  CHECK(axes_of(view_from("+z")).back == Vec3d{0, 0, 1});
  CHECK(axes_of(view_from("-z")).back == Vec3d{0, 0, -1});
  for (const std::string_view name : view_names) CHECK(name_of(view_from(name)) == name);
}

TEST_CASE("an unknown view is refused with the nearest") {
  const auto refusal = [](const char* name) {
    return message_of<InputError>([&] { (void)view_from(name); });
  };
  CHECK(refusal("frnt") == "unknown view 'frnt': did you mean 'front'?");
  CHECK(refusal("sideways").starts_with("unknown view 'sideways': known: auto, front, back, "));
}

TEST_CASE("flat groups are seen face on for any orientation") {
  const Vec3d x{1, 0, 0};
  const Vec3d y{0, 1, 0};
  const Vec3d z{0, 0, 1};
  const auto view = [](const std::vector<Sphere>& spheres, bool molecule) {
    return viewpoint_of(spheres, View::automatic, molecule);
  };
  CHECK(view(sheet(9, 5, x, y), false).frame.back == z);
  CHECK(view(sheet(9, 5, x, y), false).frame.up == y);
  CHECK(view(sheet(9, 5, x, z), false).frame.back == -y);
  CHECK(view(sheet(9, 5, y, z), false).frame.back == x);
  const Vec3d a = normalize(Vec3d{1, 2, -1});
  const Vec3d b = normalize(cross(a, Vec3d{0, 1, 3}));
  for (const bool molecule : {true, false}) {
    CAPTURE(molecule);
    const Viewpoint askew = view(sheet(9, 5, a, b), molecule);
    CHECK(std::abs(dot(askew.frame.back, cross(a, b))) > 1 - 1e-12);
    CHECK(askew.off_ground == askew.frame.back);
  }
  CHECK(std::abs(view(sheet(9, 5, x, y), true).frame.back.z) > 1 - 1e-12);
}

TEST_CASE("no camera has a negative zero, which its file would not keep") {
  const std::vector<Sphere> flat = sheet(9, 5, normalize(Vec3d{3, 1, 0}), {0, 1, 0});
  for (const bool molecule : {true, false}) {
    const Camera camera = surroundings_of(flat, 1.5, {}, {.molecule = molecule}).camera;
    for (const Vec3d& v : {camera.look_from, camera.look_at, camera.up}) {
      for (const double x : {v.x, v.y, v.z}) CHECK_FALSE((x == 0 && std::signbit(x)));
    }
  }
}

TEST_CASE("rods, balls and slabs are not flat: seen from above and aside") {
  const std::vector<Sphere> rod = sheet(20, 1, {1, 0, 0}, {0, 1, 0});
  const std::vector<Sphere> ball = cloud(500, {0, 0, 0}, {1, 1, 1}, 0.1, 5);
  const std::vector<Sphere> slab = cloud(500, {0, 0, 0}, {9, 9, 2}, 0.1, 5);
  for (const std::vector<Sphere>& spheres : {rod, ball, slab}) {
    const Viewpoint view = viewpoint_of(spheres, View::automatic, false);
    CHECK(view.off_ground == Vec3d{0, 0, 1});
    CHECK(view.frame.back.z == doctest::Approx(0.35));
    CHECK(view.frame.right.z == 0);
    CHECK(view.frame.right.x > 0.8);
    CHECK(view.frame.back.x > 0.3);  // the side at +x shows, too
  }
}

TEST_CASE(
    "molecules are seen along their principal axes whether they lie along coordinates or not") {
  const std::vector<Sphere> long_in_z = cloud(400, {0, 0, 0}, {3, 2, 12}, 0.2, 7);
  const Viewpoint molecule = viewpoint_of(long_in_z, View::automatic, true);
  const Viewpoint box = viewpoint_of(long_in_z, View::automatic, false);
  CHECK(std::abs(molecule.frame.right.z) > 0.9);
  CHECK(box.frame.right.z == 0);
}

TEST_CASE("a view that does not look down has a wall behind the particles") {
  const std::vector<Sphere> spheres = cloud(50, {0, 0, 0}, {1, 1, 1}, 0.1, 1);
  for (const View view : {View::front, View::left, View::bottom}) {
    CHECK(viewpoint_of(spheres, view, true).off_ground == axes_of(view).back);
  }
  for (const View view : {View::top, View::iso}) {
    CHECK(viewpoint_of(spheres, view, true).off_ground == Vec3d{0, 0, 1});
  }
}

}  // namespace parray
