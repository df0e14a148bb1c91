#include "cli/input/view/view.h"

#include <doctest/doctest.h>

#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "cli/input/view/surroundings.h"
#include "common/base/error.h"
#include "tests/support/message_of.h"
#include "tests/support/near.h"
#include "tests/support/rooms.h"
#include "tests/support/sphere_groups.h"

/// Views of automatic scenes.
namespace parray {
namespace {

using test::cloud;
using test::message_of;
using test::near;

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

Vec3d rotated_about_z(const Vec3d& v, double degrees) {
  const double angle = degrees / 180 * std::numbers::pi;
  return {std::cos(angle) * v.x - std::sin(angle) * v.y,
          std::sin(angle) * v.x + std::cos(angle) * v.y, v.z};
}

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
  CHECK(near(iso.back, normalize(Vec3d{4, -6, 3})));
  CHECK(iso.up.z > 0.8);
  CHECK(std::abs(iso.right.z) == 0);
  CHECK(iso.right.x > 0);
  for (const View view :
       {View::front, View::back, View::left, View::right, View::top, View::bottom, View::iso}) {
    const Axes frame = axes_of(view);
    CHECK(near(cross(frame.right, frame.up), frame.back));
  }
}

TEST_CASE("view iso shows the far corner of a cube beside the near one, and all its edges apart") {
  const Axes iso = axes_of(View::iso);
  const auto shown = [&](const Vec3d& p) { return Vec3d{dot(p, iso.right), dot(p, iso.up), 0}; };
  const Vec3d near_corner{1, 0, 1};
  const Vec3d far_corner{0, 1, 0};
  const Vec3d apart = shown(near_corner - far_corner);
  CHECK(length(apart) > 0.3);
  for (const Vec3d& edge : {Vec3d{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}) {
    const Vec3d along = shown(edge);
    CHECK(length(cross(along, apart)) / length(along) > 0.05);  // distance of the parallel edges
  }
}

TEST_CASE("up, azimuth and elevation turn every view as they say") {
  const std::vector<Sphere> spheres = cloud(50, {0, 0, 0}, {3, 2, 1}, 0.1, 4);
  const auto frame = [&](View view, const Turning& turning) {
    return viewpoint_of(spheres, view, false, turning).frame;
  };
  const Vec3d y{0, 1, 0};
  CHECK(near(frame(View::front, {.up = y}).up, y));
  CHECK(near(frame(View::front, {.up = y}).right, {1, 0, 0}));
  CHECK(near(frame(View::front, {.up = y}).back, {0, 0, 1}));
  CHECK(near(frame(View::top, {.up = y}).back, y));
  CHECK(near(frame(View::front, {.up = Vec3d{-1, 0, 0}}).up, {-1, 0, 0}));
  CHECK(near(frame(View::front, {.up = Vec3d{0, 0, 2}}).back, axes_of(View::front).back));
  CHECK(near(frame(View::front, {.azimuth = 90}).back, axes_of(View::right).back));
  CHECK(near(frame(View::front, {.azimuth = -90}).back, axes_of(View::left).back));
  CHECK(near(frame(View::front, {.azimuth = 180}).back, axes_of(View::back).back));
  CHECK(near(frame(View::front, {.elevation = 90}).back, axes_of(View::top).back));
  CHECK(near(frame(View::top, {.elevation = -90}).back, axes_of(View::front).back));
  CHECK(near(frame(View::iso, {.azimuth = 360}).back, axes_of(View::iso).back));
  CHECK(near(frame(View::iso, {.azimuth = 40}).back, rotated_about_z(axes_of(View::iso).back, 40)));
  // The angles of the automatic view are replaced.
  const Axes automatic = frame(View::automatic, {});
  const Axes front = frame(View::automatic, {.azimuth = 0, .elevation = 0});
  CHECK(near(front.back, axes_of(View::front).back));
  CHECK(frame(View::automatic, {.azimuth = 0}).back.z == doctest::Approx(automatic.back.z));
  CHECK(near(frame(View::automatic, {.up = y, .azimuth = 0, .elevation = 0}).back, {0, 0, 1}));
  for (const View view : {View::automatic, View::front, View::iso, View::bottom}) {
    for (const Vec3d& up : {Vec3d{0, 1, 0}, Vec3d{1, 2, 3}, Vec3d{-5, 0, 0}}) {
      const Axes turned = frame(view, {.up = up, .azimuth = 33, .elevation = 20});
      CHECK(near(cross(turned.right, turned.up), turned.back));
      CHECK(length(turned.up) == doctest::Approx(1));
    }
  }
}

TEST_CASE("a turned camera has a floor below it only if it looks down") {
  const std::vector<Sphere> spheres = cloud(50, {0, 0, 0}, {1, 1, 1}, 0.1, 1);
  const auto ground = [&](double elevation) {
    return viewpoint_of(spheres, View::front, false, {.elevation = elevation}).off_ground;
  };
  CHECK(ground(30) == Vec3d{0, 0, 1});
  CHECK(ground(5).z < 0.1);
  CHECK(ground(-30).z < 0);
}

TEST_CASE("directions and turns that are impossible are refused with a remedy") {
  CHECK(up_from("x") == Vec3d{1, 0, 0});
  CHECK(up_from("+y") == Vec3d{0, 1, 0});
  CHECK(up_from("-z") == Vec3d{0, 0, -1});
  CHECK(up_from("0,2,-4") == Vec3d{0, 0.5, -1});
  for (const char* text :
       {"", "w", "0,0,0", "1,2", "1,2,3,4", "1,nan,0", "1,,2", "x,y,z", "1e999,0,0"}) {
    CAPTURE(text);
    CHECK(message_of<InputError>([&] {
            (void)up_from(text);
          }).find("is not a direction: write x") != std::string::npos);
  }
  const std::vector<Sphere> one{{{0, 0, 0}, 1, 0}};
  CHECK(
      message_of<InputError>(
          [&] { (void)viewpoint_of(one, View::iso, false, {.elevation = 80}); }) ==
      "--elevation 80: the view iso would turn over the top: use a smaller angle, or another view");
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
