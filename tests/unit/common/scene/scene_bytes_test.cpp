#include "common/scene/scene_bytes.h"

#include <doctest/doctest.h>

#include <bit>
#include <cmath>
#include <cstdint>
#include <functional>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "common/base/bytes.h"
#include "common/scene/limits.h"
#include "common/scene/settings.h"
#include "common/trace/tracer.h"
#include "tests/support/dice.h"
#include "tests/support/memory.h"
#include "tests/support/rooms.h"
#include "tests/support/sample_scenes.h"
#include "tests/support/with_value.h"

namespace parray {
namespace {

using test::Dice;
using test::small_scene;
using test::with_value;

constexpr double nan = std::numeric_limits<double>::quiet_NaN();
constexpr double inf = std::numeric_limits<double>::infinity();

// Where things stand in the bytes.
constexpr std::size_t camera_at = 8;
constexpr std::size_t sky_at = camera_at + 13 * sizeof(double);
constexpr std::size_t material_count_at = sky_at + 6 * sizeof(double);
constexpr std::size_t materials_at = material_count_at + 8;
constexpr std::size_t material_size = 41;
constexpr std::size_t sphere_size = 36;

std::optional<Scene> decoded(const std::string& bytes) {
  try {
    return scene_from_bytes(bytes);
  } catch (const DecodeError&) {
    return {};
  }
}

bool refused(const std::string& bytes) { return !decoded(bytes); }

/// A scene of two materials and three spheres, small enough for exhaustive damage.
Scene tiny_scene() {
  Scene scene = small_scene();
  scene.materials.resize(2);
  scene.spheres = {{{0, -1000, 0}, 1000, 0}, {{0, 1, 0}, 1, 1}, {{4, 1, 0}, 0.5, 0}};
  return scene;
}

/// What the kernel relies on. Tracing is the proof that it may.
bool can_be_traced(const Scene& scene) {
  RenderSettings settings;
  settings.width = settings.height = 2;
  settings.max_depth = 3;
  for (const Precision precision : {Precision::f32, Precision::f64}) {
    settings.precision = precision;
    settings.accelerator = AcceleratorKind::bvh;
    const auto tracer = make_path_tracer(scene, settings);
    std::vector<PixelSums> sums(2);
    TraceCounts counts;
    tracer->trace({1, 0, 2}, {0, 2}, sums, counts);
    if (counts.samples != 4 || counts.nonfinite != 0) return false;
  }
  return true;
}

}  // namespace

TEST_CASE("a scene comes back from its bytes as it was") {
  CHECK(scene_from_bytes(scene_to_bytes(small_scene())) == small_scene());
  Scene empty;
  empty.camera.tan_half_vfov = 1;
  CHECK(scene_from_bytes(scene_to_bytes(empty)) == empty);
}

/// tiny_scene() with two capsules, one without length.
Scene tiny_sticks() {
  Scene scene = tiny_scene();
  scene.capsules = {{{0, 1, 0}, {4, 1, 0.5}, 0.25, 1}, {{2, 1, 0}, {2, 1, 0}, 0.5, 0}};
  return scene;
}

TEST_CASE("a scene with capsules has a form of its own, in which it comes back as it was") {
  Scene scene = tiny_sticks();
  const std::string bytes = scene_to_bytes(scene);
  CHECK(bytes.substr(0, 8) == "PRSCENE3");
  CHECK(scene_from_bytes(bytes) == scene);
  CHECK(bytes.size() == scene_to_bytes(tiny_scene()).size() + 8 + 2 * scene_bytes_of_capsule);
  scene.camera.projection = Projection::orthographic;
  scene.camera.view_height = 3;
  scene.camera.vfov = scene.camera.tan_half_vfov = 0;
  CHECK(scene_to_bytes(scene).substr(0, 8) == "PRSCENE4");
  CHECK(scene_from_bytes(scene_to_bytes(scene)) == scene);
}

TEST_CASE("a capsule that the kernel could not bear is refused") {
  const auto refuses = [](const std::function<void(Capsule&)>& change) {
    Scene scene = tiny_sticks();
    change(scene.capsules[0]);
    return refused(scene_to_bytes(scene));
  };
  CHECK_FALSE(refuses([](Capsule&) {}));
  CHECK(refuses([](Capsule& c) { c.radius = 0; }));
  CHECK(refuses([](Capsule& c) { c.radius = nan; }));
  CHECK(refuses([](Capsule& c) { c.from.x = inf; }));
  CHECK(refuses([](Capsule& c) { c.to.z = 2e15; }));
  CHECK(refuses([](Capsule& c) { c.material = 2; }));
  CHECK(refuses([](Capsule& c) { c.from = {0, 0, 0}, c.to = {1e-15, 0, 0}; }));
  CHECK_FALSE(refuses([](Capsule& c) { c.from = {0, 0, 0}, c.to = {2e-15, 0, 0}; }));
}

TEST_CASE("random scenes come back with the same bits") {
  Dice dice(1);
  for (int round = 0; round < 200; ++round) {
    Scene scene;
    scene.camera.look_from = dice.ten_to(-3, 6) * dice.direction();
    scene.camera.aperture = dice.ten_to(-300, 3);
    scene.camera.tan_half_vfov = dice.ten_to(-8, 5);
    scene.sky.horizon = {dice.unit(), dice.ten_to(-308, 6), 0};
    const std::uint64_t materials = 1 + dice.below(5);
    for (std::uint64_t i = 0; i < materials; ++i) {
      scene.materials.push_back({static_cast<MaterialType>(dice.below(3)),
                                 {dice.unit(), dice.unit(), dice.unit()},
                                 dice.unit(),
                                 dice.ten_to(-3, 3)});
    }
    for (std::uint64_t i = dice.below(50); i > 0; --i) {
      scene.spheres.push_back({dice.ten_to(-9, 9) * dice.direction(), dice.ten_to(-9, 9),
                               static_cast<std::uint32_t>(dice.below(materials))});
    }
    for (std::uint64_t i = dice.below(20); i > 0; --i) {
      scene.capsules.push_back({dice.ten_to(-9, 9) * dice.direction(),
                                dice.ten_to(-9, 9) * dice.direction(), dice.ten_to(-9, 9),
                                static_cast<std::uint32_t>(dice.below(materials))});
    }
    const std::string bytes = scene_to_bytes(scene);
    const Scene back = scene_from_bytes(bytes);
    REQUIRE(back == scene);
    REQUIRE(scene_to_bytes(back) == bytes);
  }
}

TEST_CASE("a scene's size is in proportion to what it holds") {
  const Scene scene = small_scene();
  CHECK(scene_to_bytes(scene).size() == materials_at + material_size * scene.materials.size() + 8 +
                                            sphere_size * scene.spheres.size());
}

TEST_CASE("equal scenes have one identity, and any change gives another") {
  const Scene scene = small_scene();
  const std::string identity = scene_identity(scene_to_bytes(scene));
  CHECK(identity.size() == 64);
  CHECK(identity.find_first_not_of("0123456789abcdef") == std::string::npos);
  CHECK(scene_identity(scene_to_bytes(small_scene())) == identity);
  const std::vector<std::function<void(Scene&)>> changes = {
      [](Scene& s) { s.camera.look_at.x = std::nextafter(s.camera.look_at.x, 1); },
      [](Scene& s) { s.camera.aperture = 0; },
      [](Scene& s) { s.camera.tan_half_vfov *= 1 + 0x1p-52; },
      [](Scene& s) { s.sky.zenith.z = 0.25; },
      [](Scene& s) { s.materials[1].fuzz = 0.25; },
      [](Scene& s) { s.materials[0].type = MaterialType::metal; },
      [](Scene& s) { s.spheres[2].material = 0; },
      [](Scene& s) { s.spheres[2].radius = 0.5; },
      [](Scene& s) { std::swap(s.spheres[0], s.spheres[1]); },
      [](Scene& s) { s.spheres.pop_back(); },
      [](Scene& s) {
        s.capsules.push_back({{0, 0, 0}, {1, 0, 0}, 0.5, 0});
      }};
  for (const auto& change : changes) {
    Scene other = scene;
    change(other);
    CHECK(scene_identity(scene_to_bytes(other)) != identity);
  }
}

TEST_CASE("a scene cut short at any length, or that goes on, is refused") {
  for (const Scene& scene : {tiny_scene(), tiny_sticks()}) {
    const std::string bytes = scene_to_bytes(scene);
    for (std::size_t size = 0; size < bytes.size(); ++size) {
      CHECK_UNARY(refused(bytes.substr(0, size)));
    }
    CHECK(refused(bytes + '\0'));
    CHECK(refused(bytes + bytes));
    CHECK_FALSE(refused(bytes));
  }
}

TEST_CASE("any damaged bit gives an error or another valid scene") {
  const std::string bytes = scene_to_bytes(tiny_sticks());
  std::size_t accepted = 0;
  std::size_t rejected = 0;
  for (std::size_t at = 0; at < bytes.size(); ++at) {
    for (int bit = 0; bit < 8; ++bit) {
      CAPTURE(at);
      CAPTURE(bit);
      std::string damaged = bytes;
      damaged[at] = static_cast<char>(damaged[at] ^ (1 << bit));
      const auto scene = decoded(damaged);
      ++(scene ? accepted : rejected);
      if (scene) {
        CHECK_UNARY(scene_to_bytes(*scene) == damaged);
        CHECK_UNARY(can_be_traced(*scene));
      }
    }
  }
  CHECK(accepted > 500);  // a digit of a coordinate
  CHECK(rejected > 200);  // a count, a type, an exponent
}

TEST_CASE("random bytes are refused and cost no more than their length") {
  Dice dice(2);
  const std::string bytes = scene_to_bytes(tiny_sticks());
  for (int round = 0; round < 20'000; ++round) {
    std::string damaged = bytes;
    for (std::uint64_t i = 1 + dice.below(6); i > 0; --i) {
      damaged[dice.below(damaged.size())] = static_cast<char>(dice.below(256));
    }
    if (dice.one_in(4)) damaged.resize(dice.below(damaged.size()));
    const auto scene = decoded(damaged);
    CHECK_UNARY((!scene || scene_to_bytes(*scene) == damaged));
  }
}

TEST_CASE("a count larger than the data is refused before anything is allocated") {
  const Scene scene = tiny_scene();
  const std::string bytes = scene_to_bytes(scene);
  const std::size_t sphere_count_at = materials_at + scene.materials.size() * material_size;
  const std::uint64_t before = test::peak_address_space();
  REQUIRE(before > 0);
  for (const std::uint64_t count : {std::uint64_t{4}, limits::max_materials, limits::max_shapes,
                                    limits::max_shapes + 1, std::uint64_t{1} << 40, UINT64_MAX,
                                    UINT64_MAX / material_size, UINT64_MAX / sphere_size + 1}) {
    CAPTURE(count);
    CHECK(refused(with_value(bytes, material_count_at, count)));
    CHECK(refused(with_value(bytes, sphere_count_at, count)));
  }
  CHECK(test::peak_address_space() - before < std::uint64_t{64} << 20);
  CHECK(refused(with_value(bytes, sphere_count_at, std::uint64_t{2})));  // one sphere is left over
}

TEST_CASE("a number that the kernel could not bear is refused") {
  const std::string bytes = scene_to_bytes(tiny_scene());
  const std::size_t spheres_at = materials_at + 2 * material_size + 8;
  struct Range {
    const char* name;
    std::size_t at;
    double low;   ///< the least that is accepted
    double high;  ///< the most
  };
  const double reach = limits::max_length;
  for (const Range& range :
       {Range{"look_from", camera_at, -reach, reach},
        Range{"look_at", camera_at + 24, -reach, reach}, Range{"up", camera_at + 48, -reach, reach},
        Range{"vfov", camera_at + 72, 0, 180}, Range{"aperture", camera_at + 80, 0, reach},
        Range{"focus", camera_at + 88, limits::min_radius, reach},
        Range{"tangent", camera_at + 96, 1e-9, 1e6},
        Range{"horizon", sky_at, 0, limits::max_radiance},
        Range{"zenith", sky_at + 40, 0, limits::max_radiance},
        Range{"albedo", materials_at + 1, 0, 1}, Range{"fuzz", materials_at + 25, 0, 1},
        Range{"center", spheres_at + 16, -reach, reach},
        Range{"radius", spheres_at + 24, limits::min_radius, reach}}) {
    CAPTURE(range.name);
    CHECK_FALSE(refused(with_value(bytes, range.at, range.low)));
    CHECK_FALSE(refused(with_value(bytes, range.at, range.high)));
    CHECK(refused(with_value(bytes, range.at, std::nextafter(range.high, inf))));
    CHECK(refused(with_value(bytes, range.at, std::nextafter(range.low, -inf))));
    for (const double bad : {nan, -nan, inf, -inf}) {
      CHECK(refused(with_value(bytes, range.at, bad)));
    }
  }
  for (const double radius : {0.0, -0.0, -1.0}) {
    CHECK(refused(with_value(bytes, spheres_at + 24, radius)));
  }
}

TEST_CASE("a reference that leads nowhere is refused") {
  const std::string bytes = scene_to_bytes(tiny_scene());
  const std::size_t spheres_at = materials_at + 2 * material_size + 8;
  CHECK(refused(with_value(bytes, spheres_at + 32, std::uint32_t{2})));
  CHECK(refused(with_value(bytes, spheres_at + 32, UINT32_MAX)));
  CHECK_FALSE(refused(with_value(bytes, spheres_at + 32, std::uint32_t{1})));
  CHECK(refused(with_value(bytes, materials_at, std::uint8_t{3})));
  CHECK(refused(with_value(bytes, materials_at, std::uint8_t{255})));
  CHECK(refused(with_value(bytes, 0, 'p')));
  CHECK(refused(with_value(bytes, 7, '2')));  // another camera
  CHECK(refused(with_value(bytes, 7, '3')));  // another version
}

TEST_CASE("a camera that looks nowhere is refused") {
  const auto refused_with = [](const std::function<void(Camera&)>& change) {
    Scene scene = tiny_scene();
    change(scene.camera);
    return refused(scene_to_bytes(scene));
  };
  CHECK(refused_with([](Camera& c) { c.look_at = c.look_from; }));
  CHECK(refused_with([](Camera& c) { c.up = {0, 0, 0}; }));
  CHECK(refused_with([](Camera& c) { c.up = c.look_from - c.look_at; }));
  CHECK_FALSE(refused_with([](Camera& c) { c.up = {0, 1e-9, 0}; }));
}

TEST_CASE("an orthographic camera has a form of its own, which older programs refuse") {
  Scene scene = tiny_scene();
  const std::string perspective = scene_to_bytes(scene);
  scene.camera.projection = Projection::orthographic;
  scene.camera.vfov = scene.camera.tan_half_vfov = 0;
  scene.camera.view_height = 3.5;
  const std::string bytes = scene_to_bytes(scene);
  CHECK(perspective.starts_with("PRSCENE1"));
  CHECK(bytes.starts_with("PRSCENE2"));
  CHECK(bytes.size() == perspective.size() - sizeof(double));
  CHECK(decoded(bytes) == scene);
  CHECK(scene_identity(scene) == scene_identity(bytes));
  CHECK(refused(with_value(bytes, 7, '1')));
  const std::size_t height_at = camera_at + 72;
  CHECK_FALSE(refused(with_value(bytes, height_at, limits::min_radius)));
  CHECK_FALSE(refused(with_value(bytes, height_at, limits::max_length)));
  for (const double bad : {nan, inf, 0.0, -1.0, std::nextafter(limits::min_radius, 0),
                           std::nextafter(limits::max_length, inf)}) {
    CHECK(refused(with_value(bytes, height_at, bad)));
  }
  for (std::size_t size = 0; size < bytes.size(); ++size) CHECK(refused(bytes.substr(0, size)));
  for (const double height : {limits::min_radius, 1.0, limits::max_length}) {
    scene.camera.view_height = height;
    CHECK(can_be_traced(scene));
  }
}

}  // namespace parray
