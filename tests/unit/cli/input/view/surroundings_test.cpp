#include "cli/input/view/surroundings.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <sstream>
#include <string>
#include <vector>

#include "cli/input/scene_file/scene_file.h"
#include "cli/input/view/view.h"
#include "common/base/error.h"
#include "tests/support/message_of.h"
#include "tests/support/rooms.h"
#include "tests/support/sphere_groups.h"

/// Checks the properties of an automatic scene.
namespace parray {
namespace {

using test::cloud;
using test::Film;
using test::Group;
using test::message_of;
using test::scaled;
using test::sphere_groups;

constexpr double aspects[] = {4.0 / 3, 1, 0.4, 3};

/// All options of automatic scenes except the size.
std::vector<Viewing> viewings() {
  std::vector<Viewing> all;
  for (const View view : {View::automatic, View::front, View::bottom, View::iso}) {
    for (const Projection projection : {Projection::perspective, Projection::orthographic}) {
      all.push_back({.view = view, .projection = projection});
    }
  }
  all.push_back({.view = View::left, .style = Style::publication});
  all.push_back({.style = Style::flat});
  all.push_back({.view = View::top, .style = Style::night});
  all.push_back({.style = Style::night});
  all.push_back({.transparent = true});
  return all;
}

struct Taken {
  std::vector<Sphere> spheres;
  Viewing viewing;
  Surroundings portrait;
  Film film;

  /// The prop of that name; none: null.
  [[nodiscard]] const Sphere* prop(std::string_view name) const {
    for (const SceneryObject& prop : portrait.scenery) {
      if (prop.name == name) return &prop.sphere;
    }
    return nullptr;
  }
};

template <typename Check>
void for_each_auto_scene(const Check& check) {
  for (const Group& group : sphere_groups()) {
    for (const Viewing& viewing : viewings()) {
      for (const double aspect : aspects) {
        for (const bool molecule : {true, false}) {
          if (!molecule && viewing.view != View::automatic) continue;
          CAPTURE(group.name);
          CAPTURE(aspect);
          CAPTURE(name_of(viewing.view));
          CAPTURE(name_of(viewing.style));
          CAPTURE(molecule);
          const Surroundings portrait =
              surroundings_of(group.spheres, aspect, viewing, {.molecule = molecule});
          check(Taken{group.spheres, viewing, portrait, Film(portrait.camera, aspect)});
        }
      }
    }
  }
}

}  // namespace

TEST_CASE("the view contains every sphere and is no wider than necessary") {
  for_each_auto_scene([](const Taken& taken) {
    Film tight = taken.film;
    tight.half_width *= 0.8501;
    tight.half_height *= 0.8501;
    double outermost = 1e300;
    for (const Sphere& sphere : taken.spheres) {
      for (const auto& [x, y] : {std::pair{1, 0}, {-1, 0}, {0, 1}, {0, -1}}) {
        CHECK(taken.film.inside(sphere, x, y) > 1);
        outermost = std::min(outermost, tight.inside(sphere, x, y) * sphere.radius - sphere.radius);
      }
      // Before the camera, all of it.
      CHECK(dot(taken.film.eye - sphere.center, taken.film.back) > sphere.radius);
    }
    const double focus = taken.portrait.camera.focus_distance;
    CHECK(outermost < 0.001 * focus);  // 0.8501 is just wider than needed
    CHECK(outermost >= -1e-9 * focus);
  });
}

TEST_CASE("the picture contains the spheres of other frames, at every angle of a turntable") {
  const std::vector<Sphere> first = cloud(100, {0, 0, 0}, {2, 3, 4}, 0.1, 12);
  const std::vector<Sphere> later = cloud(100, {3, 1, -1}, {4, 3, 2}, 0.3, 13);
  for (Viewing viewing : viewings()) {
    viewing.other_spheres = later;
    viewing.other_spheres.insert(viewing.other_spheres.end(), first.begin(), first.end());
    viewing.turns = true;
    const Surroundings portrait = surroundings_of(first, 1.5, viewing);
    for (const double degrees : {0.0, 45.0, 100.0, 213.0}) {
      const Film film(turned(portrait.camera, portrait.axis, degrees), 1.5);
      for (const Sphere& sphere : viewing.other_spheres) {
        for (const auto& [x, y] : {std::pair{1, 0}, {-1, 0}, {0, 1}, {0, -1}}) {
          CHECK(film.inside(sphere, x, y) > 1);
        }
        for (const SceneryObject& prop : portrait.scenery) {
          const Vec3d center = turned(prop.sphere.center, portrait.axis, degrees);
          CHECK(length(sphere.center - center) >
                prop.sphere.radius + sphere.radius - 1e-9 * prop.sphere.radius);
        }
      }
    }
  }
}

TEST_CASE("the picture contains the given points, and the ground is below them") {
  const std::vector<Sphere> spheres = cloud(100, {0, 0, 0}, {2, 3, 4}, 0.1, 12);
  for (const Viewing& viewing : viewings()) {
    const std::vector<Vec3d> corners = {{-5, -5, -5}, {5, 5, 5}, {9, 0, 0}};
    const Surroundings portrait = surroundings_of(spheres, 1.5, viewing, {.corners = corners});
    const Film film(portrait.camera, 1.5);
    for (const Vec3d& corner : corners) {
      for (const auto& [x, y] : {std::pair{1, 0}, {-1, 0}, {0, 1}, {0, -1}}) {
        CHECK(film.inside({corner, 1e-3, 0}, x, y) > 1);
      }
      for (const SceneryObject& prop : portrait.scenery) {
        CHECK(length(corner - prop.sphere.center) > prop.sphere.radius * (1 - 1e-12));
      }
    }
  }
}

TEST_CASE("the picture contains the ends of capsules, and the ground is below them") {
  const std::vector<Sphere> spheres = cloud(100, {0, 0, 0}, {2, 3, 4}, 0.1, 12);
  const std::vector<Capsule> capsules{{{0, 0, 0}, {9, 0, 0}, 0.5, 0},
                                      {{0, 0, 0}, {-5, -7, -8}, 1, 0}};
  for (const Viewing& viewing : viewings()) {
    const Surroundings portrait = surroundings_of(spheres, 1.5, viewing, {.capsules = capsules});
    const Film film(portrait.camera, 1.5);
    for (const Capsule& capsule : capsules) {
      for (const auto& [x, y] : {std::pair{1, 0}, {-1, 0}, {0, 1}, {0, -1}}) {
        CHECK(film.inside({capsule.to, capsule.radius, 0}, x, y) > 1);
      }
      for (const SceneryObject& prop : portrait.scenery) {
        CHECK(length(capsule.to - prop.sphere.center) >=
              (prop.sphere.radius + capsule.radius) * (1 - 1e-12));
      }
    }
  }
}

TEST_CASE("the ground touches the lowest sphere and no other is below") {
  int grounds = 0;
  for_each_auto_scene([&](const Taken& taken) {
    const Sphere* const ground = taken.prop("ground");
    CHECK((ground != nullptr) ==
          (taken.viewing.style == Style::studio && !taken.viewing.transparent));
    if (ground == nullptr) return;
    ++grounds;
    double nearest = 1e300;
    for (const Sphere& sphere : taken.spheres) {
      nearest = std::min(nearest, length(sphere.center - ground->center) - sphere.radius);
    }
    CHECK(std::abs(nearest - ground->radius) <=
          1e-12 * length(ground->center) + 1e-12 * ground->radius);
  });
  CHECK(grounds > 100);
}

TEST_CASE("ground and wall fill the picture to its corners, behind the particles") {
  for_each_auto_scene([](const Taken& taken) {
    const bool night = taken.viewing.style == Style::night;
    const Sphere* const backdrop = taken.prop(night ? "wall" : "ground");
    if (backdrop == nullptr) return;
    for (const auto& [x, y] : {std::pair{1, 1}, {-1, 1}, {1, -1}, {-1, -1}}) {
      CHECK(taken.film.hits(x, y, *backdrop));
      CHECK(length(taken.film.origin(x, y) - backdrop->center) > backdrop->radius);
    }
    for (const Sphere& sphere : taken.spheres) {
      CHECK(length(sphere.center - backdrop->center) >
            (backdrop->radius + sphere.radius) * (1 - 1e-12));
    }
  });
}

TEST_CASE("the light blocker is outside the picture and contains neither camera nor particles") {
  for_each_auto_scene([](const Taken& taken) {
    const Sphere* const flag = taken.prop("flag");
    CHECK((flag == nullptr) == (taken.viewing.style == Style::flat));
    if (flag == nullptr) return;
    for (const double x : {-1.0, -0.5, 0.0, 0.5, 1.0}) {
      for (const double y : {-1.0, -0.5, 0.0, 0.5, 1.0}) {
        CHECK_FALSE(taken.film.hits(x, y, *flag));
        CHECK(length(taken.film.origin(x, y) - flag->center) > flag->radius);
      }
    }
    for (const Sphere& sphere : taken.spheres) {
      CHECK(length(sphere.center - flag->center) > flag->radius + sphere.radius);
    }
  });
}

TEST_CASE("scaling by a power of two scales the automatic scene exactly") {
  for (const Group& group : sphere_groups()) {
    CAPTURE(group.name);
    for (const Viewing& viewing : viewings()) {
      const Surroundings portrait = surroundings_of(group.spheres, 1.5, viewing);
      for (const double factor : {0x1p-7, 0x1p9}) {
        const Surroundings other = surroundings_of(scaled(group.spheres, factor), 1.5, viewing);
        CHECK(other.camera.look_from == factor * portrait.camera.look_from);
        CHECK(other.camera.look_at == factor * portrait.camera.look_at);
        CHECK(other.camera.up == portrait.camera.up);
        CHECK(other.camera.focus_distance == factor * portrait.camera.focus_distance);
        CHECK(other.camera.vfov == portrait.camera.vfov);
        CHECK(other.camera.tan_half_vfov == portrait.camera.tan_half_vfov);
        CHECK(other.camera.view_height == factor * portrait.camera.view_height);
        CHECK(other.sky == portrait.sky);
        for (std::size_t i = 0; i < portrait.scenery.size(); ++i) {
          CHECK(other.scenery[i].sphere.center == factor * portrait.scenery[i].sphere.center);
          CHECK(other.scenery[i].sphere.radius == factor * portrait.scenery[i].sphere.radius);
        }
        CHECK(lattice_radius(scaled(group.spheres, factor)) ==
              (group.name.find("one") == std::string::npos ? factor : 1) *
                  lattice_radius(group.spheres));
      }
    }
  }
}

TEST_CASE("every automatic scene is written and read back to the same bits") {
  for_each_auto_scene([](const Taken& taken) {
    SceneFile file;
    file.scene = {taken.portrait.camera, taken.portrait.sky, {plain_material}, taken.spheres, {}};
    for (const SceneryObject& prop : taken.portrait.scenery) {
      file.scene.spheres.push_back(prop.sphere);
    }
    file.postprocessing = postprocessing_of(taken.viewing.style);
    std::stringstream text;
    write_scene(text, file, [] {});
    remove_duplicates(file.scene);  // as the reader does
    const SceneFile read = read_scene(text, "s.json");
    CHECK(read.scene == file.scene);
    CHECK(read.postprocessing == file.postprocessing);
  });
}

TEST_CASE("the longest axis lies across the picture and the shortest points at the viewer") {
  // The axes of this slab: long (2, 1, 0), middle (-1, 2, 0), short (0, 0, 1), all turned over.
  std::vector<Sphere> spheres = cloud(2000, {0, 0, 0}, {30, 12, 2}, 0.3, 9);
  const Vec3d a = normalize(Vec3d{2, 1, 0.5});
  const Vec3d c = normalize(cross(a, Vec3d{-1, 2, 3}));
  const Vec3d b = cross(c, a);
  for (Sphere& s : spheres) s.center = s.center.x * a + s.center.y * b + s.center.z * c;
  const Axes frame = principal_axes(spheres);
  CHECK(std::abs(dot(frame.right, a)) > 0.99);
  CHECK(std::abs(dot(frame.up, b)) > 0.98);
  CHECK(std::abs(dot(frame.back, c)) > 0.98);
  const Film film(surroundings_of(spheres, 1.5).camera, 1.5);
  CHECK(std::abs(dot(film.right, a)) > 0.95);
  CHECK(std::abs(dot(film.back, c)) > 0.9);
  CHECK(dot(film.back, frame.up) > 0.25);  // from above
}

TEST_CASE("the frame is right-handed with unit axes, and its signs follow the coordinates") {
  for (const Group& group : sphere_groups()) {
    CAPTURE(group.name);
    const Axes f = principal_axes(group.spheres);
    CHECK(length(cross(f.right, f.up) - f.back) < 1e-14);
    for (const Vec3d& axis : {f.right, f.up, f.back}) CHECK(std::abs(length(axis) - 1) < 1e-15);
    for (const Vec3d& axis : {f.up, f.back}) {
      const auto [low, high] = std::minmax({axis.x, axis.y, axis.z});
      CHECK(high >= -low - 1e-12);
    }
  }
}

TEST_CASE("a group with equal spread along all axes keeps the coordinate axes") {
  for (const Group& group : sphere_groups()) {
    if (group.name != "one" && group.name != "a lattice" && group.name != "three at one place") {
      continue;
    }
    CAPTURE(group.name);
    const Axes frame = principal_axes(group.spheres);
    CHECK(frame.right == Vec3d{1, 0, 0});
    CHECK(frame.up == Vec3d{0, 1, 0});
    CHECK(frame.back == Vec3d{0, 0, 1});
  }
  // 1 % of noise on a lattice turns it by a few degrees, not by anything.
  std::vector<Sphere> noisy = sphere_groups().back().spheres;
  const std::vector<Sphere> noise = cloud(noisy.size(), {0, 0, 0}, {0.02, 0.02, 0.02}, 1, 11);
  for (std::size_t i = 0; i < noisy.size(); ++i) {
    noisy[i].center = noisy[i].center + noise[i].center;
  }
  CHECK(dot(principal_axes(noisy).up, Vec3d{0, 1, 0}) > 0.99);
}

TEST_CASE("the lattice radius is half the spacing for any rotation and dimension") {
  const Vec3d a = normalize(Vec3d{1, 2, -1});
  const Vec3d b = normalize(cross(a, Vec3d{0, 1, 3}));
  const Vec3d c = cross(a, b);
  for (const auto& [nx, ny, nz] :
       {std::array{7, 5, 3}, {2, 2, 2}, {9, 4, 1}, {2, 1, 1}, {100, 1, 1}, {30, 30, 1}}) {
    std::vector<Sphere> spheres;
    for (int i = 0; i < nx * ny * nz; ++i) {
      const double x = 2.5 * (i % nx);
      const double y = 2.5 * (i / nx % ny);
      const int layer = i / nx / ny;
      const double z = 2.5 * layer;
      spheres.push_back({Vec3d{3, 4, 5} + x * a + y * b + z * c, 1, 0});
    }
    CAPTURE(spheres.size());
    CHECK(lattice_radius(spheres) == doctest::Approx(1.25).epsilon(1e-6));
  }
  CHECK(lattice_radius(std::vector<Sphere>(3, {{1, 2, 3}, 9, 0})) == 1);
}

TEST_CASE("a group too large or too far away is refused") {
  const std::vector<Sphere> vast = cloud(20, {0, 0, 0}, {1e14, 1e14, 1e14}, 1e12, 1);
  CHECK(message_of<InputError>([&] {
          (void)surroundings_of(vast, 1);
        }).ends_with("above the limit of 1e+15: scale the coordinates down"));
  const std::vector<Sphere> far = {{{1e9, 0, 0}, 1e-9, 0}};
  CHECK(message_of<InputError>([&] { (void)surroundings_of(far, 1); }) ==
        "the particles are too far from the origin for their size: move them closer to it");
}

}  // namespace parray
