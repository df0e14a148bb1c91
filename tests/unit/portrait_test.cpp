#include "common/input/portrait/portrait.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <sstream>
#include <string>
#include <vector>

#include "common/base/error.h"
#include "common/input/portrait/principal_axes.h"
#include "common/input/scene_writer.h"
#include "tests/support/message_of.h"

/// What a portrait promises, whatever it is of.
namespace parray {
namespace {

using test::message_of;

struct Group {
  std::string name;
  std::vector<Sphere> spheres;
};

/// Centres uniform in a box around `center`, radii up to `radius`.
std::vector<Sphere> cloud(std::size_t count, const Vec3d& center, const Vec3d& size, double radius,
                          std::uint64_t seed) {
  std::mt19937_64 random(seed);
  const auto uniform = [&] { return std::uniform_real_distribution<>(-0.5, 0.5)(random); };
  std::vector<Sphere> spheres;
  for (std::size_t i = 0; i < count; ++i) {
    const Vec3d offset{uniform(), uniform(), uniform()};
    spheres.push_back({center + size * offset, radius * (0.75 + 0.5 * uniform()), 0});
  }
  return spheres;
}

std::vector<Group> groups() {
  std::vector<Group> all = {
      {"one", {{{1, 2, 3}, 1.5, 0}}},
      {"one at the origin", {{{0, 0, 0}, 1, 0}}},
      {"three at one place", {{{4, 5, 6}, 1, 0}, {{4, 5, 6}, 2, 0}, {{4, 5, 6}, 1, 0}}},
      {"two", {{{0, 0, 0}, 1, 0}, {{0, 3, 0}, 0.25, 0}}},
      {"a ball", cloud(1000, {0, 0, 0}, {1, 1, 1}, 0.05, 1)},
      {"a slab", cloud(1000, {7, -8, 9}, {20, 2, 30}, 1, 2)},
      {"a rod", cloud(500, {0, 50, 0}, {1, 1, 90}, 0.3, 3)},
      {"a plane", cloud(300, {0, 0, 5}, {30, 20, 0}, 0.5, 4)},
      {"tiny", cloud(50, {0, 0, 0}, {1e-9, 3e-9, 2e-9}, 1e-10, 5)},
      {"vast", cloud(50, {0, 0, 0}, {1e9, 3e9, 2e9}, 1e8, 6)},
      {"far away", cloud(50, {1e6, -1e6, 1e6}, {1, 3, 2}, 0.1, 7)},
      {"points, nearly", cloud(50, {0, 0, 0}, {1, 3, 2}, 1e-12, 8)},
      {"a giant among dwarfs", {{{0, 0, 0}, 1e-3, 0}, {{1, 0, 0}, 1e3, 0}, {{5, 1, 0}, 1e-3, 0}}}};
  Group line{"a line", {}};
  Group lattice{"a lattice", {}};
  for (int i = 0; i < 125; ++i) {
    line.spheres.push_back({{1.0 * i, 2.0 * i, -1.0 * i}, 0.5, 0});
    const int layer = i / 25;
    lattice.spheres.push_back({{1.0 * (i % 5), 1.0 * (i / 5 % 5), 1.0 * layer}, 0.5, 0});
  }
  all.push_back(std::move(line));
  all.push_back(std::move(lattice));
  return all;
}

/// The view's axes, as trace/view.h has them, and how far the film reaches at distance 1.
struct Film {
  Film(const Camera& camera, double aspect)
      : eye(camera.look_from),
        back(normalize(camera.look_from - camera.look_at)),
        right(normalize(cross(camera.up, back))),
        up(cross(back, right)),
        half_width(camera.tan_half_vfov * aspect),
        half_height(camera.tan_half_vfov) {}

  /// How far, in radii, a sphere stays inside the plane through the eye whose normal in the picture
  /// is (x, y): >= 1 is all inside, <= -1 all outside.
  [[nodiscard]] double inside(const Sphere& sphere, double x, double y) const {
    const Vec3d p = sphere.center - eye;
    const double reach = std::abs(x) * half_width + std::abs(y) * half_height;
    const Vec3d normal = x * right + y * up + reach * back;
    return -dot(p, normal) / length(normal) / sphere.radius;
  }
  [[nodiscard]] Vec3d ray(double x, double y) const {
    return normalize((x * half_width) * right + (y * half_height) * up - back);
  }

  Vec3d eye, back, right, up;
  double half_width, half_height;
};

constexpr double aspects[] = {4.0 / 3, 1, 0.4, 3};

bool hits(const Vec3d& origin, const Vec3d& direction, const Sphere& sphere) {
  const Vec3d to_center = sphere.center - origin;
  const double along = dot(to_center, direction);
  const double off = length(to_center - along * direction);
  return along > 0 && off < sphere.radius;
}

template <typename Check>
void for_each_portrait(const Check& check) {
  for (const Group& group : groups()) {
    for (const double aspect : aspects) {
      CAPTURE(group.name);
      CAPTURE(aspect);
      const Portrait portrait = portrait_of(group.spheres, aspect);
      check(group.spheres, portrait, Film(portrait.camera, aspect));
    }
  }
}

std::vector<Sphere> scaled(std::vector<Sphere> spheres, double factor) {
  for (Sphere& sphere : spheres) {
    sphere.center = factor * sphere.center;
    sphere.radius *= factor;
  }
  return spheres;
}

}  // namespace

TEST_CASE("every sphere is inside the view, and the view is no wider than that") {
  for_each_portrait([](const std::vector<Sphere>& spheres, const Portrait& portrait,
                       const Film& film) {
    Film tight = film;
    tight.half_width *= 0.8501;
    tight.half_height *= 0.8501;
    double outermost = 1e300;
    for (const Sphere& sphere : spheres) {
      for (const auto& [x, y] : {std::pair{1, 0}, {-1, 0}, {0, 1}, {0, -1}}) {
        CHECK(film.inside(sphere, x, y) > 1);
        outermost = std::min(outermost, tight.inside(sphere, x, y) * sphere.radius - sphere.radius);
      }
    }
    CHECK(outermost < 0.001 * portrait.camera.focus_distance);  // 0.8501 is just wider than needed
    CHECK(outermost >= 0);
  });
}

TEST_CASE("the ground touches the lowest sphere and no other is below") {
  for_each_portrait([](const std::vector<Sphere>& spheres, const Portrait& portrait, const Film&) {
    const Sphere& ground = portrait.ground;
    double nearest = 1e300;
    for (const Sphere& sphere : spheres) {
      nearest = std::min(nearest, length(sphere.center - ground.center) - sphere.radius);
    }
    CHECK(std::abs(nearest - ground.radius) <=
          1e-12 * length(ground.center) + 1e-12 * ground.radius);
  });
}

TEST_CASE("the ground fills the picture to its corners, and the flag is out of it") {
  for_each_portrait([](const std::vector<Sphere>& spheres, const Portrait& portrait,
                       const Film& film) {
    for (const auto& [x, y] : {std::pair{1, 1}, {-1, 1}, {1, -1}, {-1, -1}}) {
      CHECK(hits(film.eye, film.ray(x, y), portrait.ground));
    }
    CHECK(film.inside(portrait.flag, 1, 0) < -1);
    CHECK(length(film.eye - portrait.flag.center) > portrait.flag.radius);
    CHECK(length(film.eye - portrait.ground.center) > portrait.ground.radius);
    for (const Sphere& sphere : spheres) {
      CHECK(length(sphere.center - portrait.flag.center) > portrait.flag.radius + sphere.radius);
    }
  });
}

TEST_CASE("scaling by a power of two scales the portrait exactly") {
  for (const Group& group : groups()) {
    CAPTURE(group.name);
    const Portrait portrait = portrait_of(group.spheres, 1.5);
    for (const double factor : {0x1p-7, 0x1p9}) {
      const Portrait other = portrait_of(scaled(group.spheres, factor), 1.5);
      CHECK(other.camera.look_from == factor * portrait.camera.look_from);
      CHECK(other.camera.look_at == factor * portrait.camera.look_at);
      CHECK(other.camera.up == portrait.camera.up);
      CHECK(other.camera.focus_distance == factor * portrait.camera.focus_distance);
      CHECK(other.camera.vfov == portrait.camera.vfov);
      CHECK(other.camera.tan_half_vfov == portrait.camera.tan_half_vfov);
      CHECK(other.sky == portrait.sky);
      for (const auto& [big, small] :
           {std::pair(other.ground, portrait.ground), std::pair(other.flag, portrait.flag)}) {
        CHECK(big.center == factor * small.center);
        CHECK(big.radius == factor * small.radius);
      }
      CHECK(lattice_radius(scaled(group.spheres, factor)) ==
            (group.name.find("one") == std::string::npos ? factor : 1) *
                lattice_radius(group.spheres));
    }
  }
}

TEST_CASE("the reader takes every portrait as the writer writes it, bit by bit") {
  for_each_portrait([](const std::vector<Sphere>& spheres, const Portrait& portrait, const Film&) {
    SceneFile file;
    file.scene = {portrait.camera, portrait.sky, {portrait_ground}, spheres};
    file.scene.spheres.push_back(portrait.ground);
    file.scene.spheres.push_back(portrait.flag);
    std::stringstream text;
    write_scene(text, file, [] {});
    remove_duplicates(file.scene);  // as the reader does
    CHECK(read_scene(text, "s.json").scene == file.scene);
  });
}

TEST_CASE("the longest axis lies across the picture and the shortest points at the viewer") {
  // The axes of this slab: long (2, 1, 0), middle (-1, 2, 0), short (0, 0, 1), all turned over.
  std::vector<Sphere> spheres = cloud(2000, {0, 0, 0}, {30, 12, 2}, 0.3, 9);
  const Vec3d a = normalize(Vec3d{2, 1, 0.5});
  const Vec3d c = normalize(cross(a, Vec3d{-1, 2, 3}));
  const Vec3d b = cross(c, a);
  for (Sphere& s : spheres) s.center = s.center.x * a + s.center.y * b + s.center.z * c;
  const Frame frame = principal_axes(spheres);
  CHECK(std::abs(dot(frame.right, a)) > 0.99);
  CHECK(std::abs(dot(frame.up, b)) > 0.98);
  CHECK(std::abs(dot(frame.back, c)) > 0.98);
  const Film film(portrait_of(spheres, 1.5).camera, 1.5);
  CHECK(std::abs(dot(film.right, a)) > 0.95);
  CHECK(std::abs(dot(film.back, c)) > 0.9);
  CHECK(dot(film.back, frame.up) > 0.25);  // from above
}

TEST_CASE("the frame is right-handed with unit axes, and its signs follow the coordinates") {
  for (const Group& group : groups()) {
    CAPTURE(group.name);
    const Frame f = principal_axes(group.spheres);
    CHECK(length(cross(f.right, f.up) - f.back) < 1e-14);
    for (const Vec3d& axis : {f.right, f.up, f.back}) CHECK(std::abs(length(axis) - 1) < 1e-15);
    for (const Vec3d& axis : {f.up, f.back}) {
      const auto [low, high] = std::minmax({axis.x, axis.y, axis.z});
      CHECK(high >= -low - 1e-12);
    }
  }
}

TEST_CASE("what spreads alike along all axes stands as its coordinates do") {
  for (const Group& group : groups()) {
    if (group.name != "one" && group.name != "a lattice" && group.name != "three at one place") {
      continue;
    }
    CAPTURE(group.name);
    const Frame frame = principal_axes(group.spheres);
    CHECK(frame.right == Vec3d{1, 0, 0});
    CHECK(frame.up == Vec3d{0, 1, 0});
    CHECK(frame.back == Vec3d{0, 0, 1});
  }
  // 1 % of noise on a lattice turns it by a few degrees, not by anything.
  std::vector<Sphere> noisy = groups().back().spheres;
  const std::vector<Sphere> noise = cloud(noisy.size(), {0, 0, 0}, {0.02, 0.02, 0.02}, 1, 11);
  for (std::size_t i = 0; i < noisy.size(); ++i) {
    noisy[i].center = noisy[i].center + noise[i].center;
  }
  CHECK(dot(principal_axes(noisy).up, Vec3d{0, 1, 0}) > 0.99);
}

TEST_CASE("the lattice's radius is half its spacing, however it is turned and in any dimension") {
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

TEST_CASE("a group that no portrait can hold is refused") {
  const std::vector<Sphere> vast = cloud(20, {0, 0, 0}, {1e14, 1e14, 1e14}, 1e12, 1);
  CHECK(message_of<InputError>([&] {
          (void)portrait_of(vast, 1);
        }).ends_with("beyond 1e+15: scale the coordinates down"));
  const std::vector<Sphere> far = {{{1e9, 0, 0}, 1e-9, 0}};
  CHECK(message_of<InputError>([&] { (void)portrait_of(far, 1); }) ==
        "the particles are too far from the origin for their size: move them nearer");
}

}  // namespace parray
