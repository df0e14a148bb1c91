// Automatic cameras and labels together: no label covers a particle.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "cli/input/view/surroundings.h"
#include "cli/output/labels/labels.h"
#include "tests/support/rooms.h"
#include "tests/support/sphere_groups.h"

namespace parray {
namespace {

using test::cloud;
using test::Film;
using test::Group;
using test::sphere_groups;

/// Returns whether a sphere lies completely on one side of a line of the picture: towards larger x
/// (or y) of x = place, from -1 to 1, or towards smaller ones.
bool beyond(const Film& film, const Sphere& sphere, bool across, double place, bool larger) {
  const Vec3d side = across ? film.right : film.up;
  const double at = place * (across ? film.half_width : film.half_height);
  const Vec3d p = sphere.center - film.eye;
  const Vec3d normal = film.parallel ? side : side + at * film.back;
  const double distance = (dot(p, normal) - (film.parallel ? at : 0)) / length(normal);
  const double rounding = 1e-9 * length(p);
  return (larger ? distance : -distance) >= sphere.radius - rounding;
}

bool is_clear(const Film& film, const Sphere& sphere, const PictureArea& box) {
  return beyond(film, sphere, true, box.left, false) ||
         beyond(film, sphere, true, box.right, true) ||
         beyond(film, sphere, false, box.bottom, false) ||
         beyond(film, sphere, false, box.top, true);
}

PictureArea area_of(const Box& box, double width, double height) {
  return {2 * box.x / width - 1, 2 * (box.x + box.width) / width - 1,
          1 - 2 * (box.y + box.height) / height, 1 - 2 * box.y / height};
}

std::vector<Viewing> viewings() {
  std::vector<Viewing> all;
  for (const View view : {View::automatic, View::front, View::top, View::iso}) {
    for (const Projection projection : {Projection::perspective, Projection::orthographic}) {
      all.push_back({.view = view, .projection = projection});
    }
  }
  all.push_back({.turning = {.azimuth = 50, .elevation = 60}});
  all.push_back({.zoom = 0.5});
  return all;
}

/// The boxes in which a view contains all spheres, and none in a box.
void check(const Film& film, const std::vector<Sphere>& spheres,
           const std::vector<PictureArea>& boxes) {
  for (const Sphere& sphere : spheres) {
    for (const auto& [x, y] : {std::pair{1, 0}, {-1, 0}, {0, 1}, {0, -1}}) {
      if (!(film.inside(sphere, x, y) > 1)) FAIL_CHECK("outside the picture");
    }
    if (dot(film.eye - sphere.center, film.back) <= sphere.radius) FAIL_CHECK("behind the camera");
    for (const PictureArea& box : boxes) {
      if (!is_clear(film, sphere, box)) FAIL_CHECK("a label covers a sphere");
    }
  }
}

}  // namespace

TEST_CASE("no sphere meets a label in any view, shape of picture and corner") {
  const std::vector<PictureArea> corners = {
      {-1, -0.45, 0.7, 1}, {0.5, 1, -0.1, 1}, {-1, -0.7, -1, -0.5}, {0.3, 1, -1, -0.75}};
  for (const Group& group : sphere_groups()) {
    for (const Viewing& viewing : viewings()) {
      for (const double aspect : {4.0 / 3, 1.0, 0.4, 3.0}) {
        for (unsigned chosen = 0; chosen < 16; ++chosen) {
          std::vector<PictureArea> boxes;
          for (unsigned i = 0; i < 4; ++i) {
            if ((chosen >> i & 1U) != 0) boxes.push_back(corners[i]);
          }
          CAPTURE(group.name);
          CAPTURE(aspect);
          CAPTURE(name_of(viewing.view));
          CAPTURE(chosen);
          const Subject subject{.labels = [&](const Camera&) { return LabelPlaces{boxes}; }};
          const Surroundings around = surroundings_of(group.spheres, aspect, viewing, subject);
          const Film film(around.camera, aspect);
          check(film, group.spheres, boxes);
          for (const SceneryObject& prop : around.scenery) {
            if (prop.name != "ground") continue;
            for (const auto& [x, y] : {std::pair{1, 1}, {-1, 1}, {1, -1}, {-1, -1}}) {
              CHECK(film.hits(x, y, prop.sphere));
            }
          }
        }
      }
    }
  }
}

TEST_CASE("labels at the edges change no camera, and others no direction") {
  const std::vector<Sphere> spheres = cloud(100, {1, 2, 3}, {2, 3, 4}, 0.1, 5);
  for (const Viewing& viewing : viewings()) {
    const auto camera_with = [&](const PictureArea& box) {
      const Subject subject{.labels = [&](const Camera&) { return LabelPlaces{{box}}; }};
      return surroundings_of(spheres, 1.5, viewing, subject).camera;
    };
    const Camera bare = surroundings_of(spheres, 1.5, viewing).camera;
    CHECK(camera_with({0.9, 1, 0.9, 1}).look_from == bare.look_from);
    const Camera moved = camera_with({-0.2, 1, -1, 1});
    CHECK(length(normalize(moved.look_from - moved.look_at) -
                 normalize(bare.look_from - bare.look_at)) < 1e-9);
    CHECK(length(moved.look_from - bare.look_from) > 0.1);
  }
}

TEST_CASE("the real labels of pictures of many sizes and views cover no particle") {
  const std::vector<Sphere> spheres = cloud(300, {5, 5, 5}, {10, 10, 10}, 0.8, 3);
  const ParticleCell cell{{0, 0, 0}, {Vec3d{10, 0, 0}, {0, 10, 0}, {0, 0, 10}}};
  std::vector<Vec3d> corners;
  for (unsigned i = 0; i < 8; ++i) {
    corners.push_back({10.0 * (i & 1U), 5.0 * (i & 2U), 2.5 * (i & 4U)});
  }
  Legend legend{
      .title = "a long title of a legend", .low = -1, .high = 1, .stops = {{0, 0, 1}, {1, 0, 0}}};
  const std::vector<std::pair<std::uint32_t, std::uint32_t>> sizes = {
      {1200, 900}, {240, 180}, {500, 900}, {1000, 300}};
  for (const auto& size : sizes) {
    const std::uint32_t width = size.first;
    const std::uint32_t height = size.second;
    for (const Viewing& viewing : viewings()) {
      CAPTURE(width);
      CAPTURE(name_of(viewing.view));
      LabelContent content{.settings = {.legend = true, .scale_bar = true, .cell = true},
                           .legends = {legend}};
      content.cell = cell;
      content.unit = "angstrom";
      content.width = width;
      content.height = height;
      content.scenery = 2;
      const Subject subject{.corners = corners, .labels = [&](const Camera& camera) {
                              content.camera = camera;
                              return Labels::places(content);
                            }};
      const double aspect = 1.0 * width / height;
      const Camera camera = surroundings_of(spheres, aspect, viewing, subject).camera;
      content.camera = camera;
      std::vector<PictureArea> boxes;
      for (const Box& box : Labels(content).boxes()) boxes.push_back(area_of(box, width, height));
      REQUIRE(boxes.size() == 3);
      check(Film(camera, aspect), spheres, boxes);
    }
  }
}

TEST_CASE("the name of a cell's edge moves away from particles") {
  const ParticleCell cell{{-1, -1, -1}, {Vec3d{2, 0, 0}, {0, 2, 0}, {0, 0, 2}}};
  LabelContent content{.settings = {.cell = true}, .cell = cell};
  content.camera = surroundings_of(std::vector<Sphere>{{{0, 0, 0}, 3, 0}}, 1, {}).camera;
  content.width = content.height = 600;
  content.scenery = 1;
  const double em = 8 * dots_per_inch(content.settings, 600) / 72;
  // A disc of particles whose edge is 20 pixels outside the places of the names.
  std::vector<float> depth(600 * 600, std::numeric_limits<float>::infinity());
  std::vector<std::uint32_t> sphere(600 * 600, 0xffffffff);
  constexpr double radius = 200;
  const auto in_disc = [&](std::size_t x, std::size_t y) {
    return std::hypot(static_cast<double>(x) - 300, static_cast<double>(y) - 300) < radius;
  };
  for (std::size_t y = 0; y < 600; ++y) {
    for (std::size_t x = 0; x < 600; ++x) {
      if (in_disc(x, y)) {
        sphere[600 * y + x] = 1;
        depth[600 * y + x] = 0;  // hides the lines of the cell behind it
      }
    }
  }
  Image picture{600, 600, std::vector<float>(std::size_t{3} * 600 * 600, 0.8F)};
  std::vector<float> opaque;
  Labels{content}.draw(picture, opaque, {depth, sphere, 1});
  std::size_t inked = 0;
  for (std::size_t y = 0; y < 600; ++y) {
    for (std::size_t x = 0; x < 600; ++x) {
      const bool black = picture.rgb[3 * (600 * y + x)] < 0.05F;
      const bool axes = static_cast<double>(x)<9 * em&& static_cast<double>(y)> 600 - 9 * em;
      if (black && in_disc(x, y)) FAIL_CHECK("a name covers a particle at ", x, ", ", y);
      inked += black && !axes ? 1 : 0;
    }
  }
  CHECK(inked > 20);  // the names are somewhere
}

}  // namespace parray
