#include <doctest/doctest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <numbers>
#include <string>

#include "cli/input/scene_file/scene_file.h"
#include "common/scene/settings.h"
#include "tests/support/rooms.h"
#include "tests/support/scene_text.h"

namespace parray {
namespace {

using test::message_of_scene;
using test::read_scene_text;

using Json = nlohmann::json;

Json scene_cases() {
  std::ifstream file(PARRAY_SOURCE_DIR "/tests/unit/cli/input/scene_file/scene_cases.json");
  REQUIRE(file);
  return Json::parse(file);
}

std::string text_of(const Json& cases, const Json& one) {
  if (one.contains("document")) return one["document"].dump();
  Json document = cases["base"];
  document.merge_patch(one["patch"]);
  return document.dump();
}

}  // namespace

TEST_CASE("a scene of version 1 is read in full") {
  const SceneFile file = read_scene_text(R"({
    "version": 1,
    "camera": {"look_from": [0, 1, 2], "look_at": [0, 1, -2], "up": [1, 1, 0], "vfov": 90,
               "aperture": 0.5, "focus_distance": 3},
    "image": {"width": 64, "height": 48},
    "render": {"samples_per_pixel": 7, "max_depth": 9, "seed": 18446744073709551615},
    "sky": {"horizon": [0.1, 0.2, 0.3], "zenith": [4, 5, 6]},
    "materials": {"m": {"type": "metal", "albedo": [0.25, 0.5, 1], "fuzz": 0.125},
                  "g": {"type": "dielectric", "ior": 1.5},
                  "d": {"type": "diffuse", "albedo": [0, 0.5, 1]}},
    "spheres": [{"center": [1, -2, 3.5], "radius": 0.25, "material": "g"},
                {"center": [0, 0, 0], "radius": 1e3, "material": "m"}]})");
  CHECK_FALSE(file.seed_format);
  const Camera& camera = file.scene.camera;
  CHECK(camera.look_from == Vec3d{0, 1, 2});
  CHECK(camera.look_at == Vec3d{0, 1, -2});
  CHECK(camera.up == Vec3d{1, 1, 0});
  CHECK(camera.vfov == 90);
  CHECK(camera.aperture == 0.5);
  CHECK(camera.focus_distance == 3);
  CHECK(camera.tan_half_vfov == doctest::Approx(1));
  CHECK(file.settings->width == 64);
  CHECK(file.settings->height == 48);
  CHECK(file.settings->samples_per_pixel == 7);
  CHECK(file.settings->max_depth == 9);
  CHECK(file.settings->seed == UINT64_MAX);
  CHECK(file.scene.sky == Sky{{0.1, 0.2, 0.3}, {4, 5, 6}});
  // In the order of first use; the unused one is gone.
  const Material glass{MaterialType::dielectric, {1, 1, 1}, 0, 1.5};
  const Material metal{MaterialType::metal, {0.25, 0.5, 1}, 0.125, 1};
  CHECK(file.scene.materials == std::vector<Material>{glass, metal});
  CHECK(file.scene.spheres == std::vector<Sphere>{{{1, -2, 3.5}, 0.25, 0}, {{0, 0, 0}, 1000, 1}});
}

TEST_CASE("members that a scene of version 1 omits have their defaults") {
  const SceneFile file = read_scene_text(R"({"version": 1, "camera": {"look_from": [0, 3, 4],
      "look_at": [0, 0, 0], "vfov": 20}, "materials": {}, "spheres": []})");
  CHECK(file.settings == RenderSettings{});
  CHECK(file.scene.sky == Sky{});
  CHECK(file.scene.camera.up == Vec3d{0, 1, 0});
  CHECK(file.scene.camera.aperture == 0);
  CHECK(file.scene.camera.focus_distance == 5);  // |look_from - look_at|
  CHECK(file.scene.camera.tan_half_vfov == std::tan(10 * (std::numbers::pi / 180)));
  CHECK(file.scene.spheres.empty());
  CHECK(file.scene.materials.empty());
}

TEST_CASE("a scene in the seed format and in version 1 gives equal scenes") {
  const SceneFile seed = read_scene_text(R"({"spheres": [
    {"sphere": {"location": {"x": 0, "y": -0.0, "z": 2}, "radius": 0.5,
                "material": {"type": "lambertian", "color": {"r": 0.1, "g": 0.2, "b": 0.3}}}},
    {"sphere": {"radius": 1.0, "location": {"x": 1, "y": 2, "z": 3},
                "material": {"type": "dielectric", "refraction_index": 1.5}}},
    {"sphere": {"location": {"x": 5, "y": 6, "z": 7}, "radius": 2,
                "material": {"type": "lambertian", "color": {"b": 0.3, "g": 0.2, "r": 0.1}}}},
    {"sphere": {"location": {"x": 8, "y": 9, "z": 10}, "radius": 3,
                "material": {"type": "metal", "fuzz": 0.25,
                             "color": {"r": 1, "g": 0, "b": 0.5}}}}]})");
  // Two names for one surface, one that nobody uses, and all of them after the spheres.
  const SceneFile twin = read_scene_text(R"({"version": 1, "spheres": [
      {"center": [0, 0, 2], "radius": 0.5, "material": "grey"},
      {"center": [1, 2, 3], "radius": 1, "material": "glass"},
      {"center": [5, 6, 7], "radius": 2, "material": "also grey"},
      {"center": [8, 9, 10], "radius": 3, "material": "pink"}],
    "materials": {"unused": {"type": "dielectric", "ior": 1.3},
      "pink": {"type": "metal", "albedo": [1, 0, 0.5], "fuzz": 0.25},
      "also grey": {"type": "diffuse", "albedo": [0.1, 0.2, 0.3]},
      "glass": {"type": "dielectric", "ior": 1.5},
      "grey": {"type": "diffuse", "albedo": [0.1, 0.2, 0.3]}},
    "camera": {"look_from": [13, 2, 3], "look_at": [0, 0, 0], "vfov": 20, "aperture": 0.1,
               "focus_distance": 10}})");
  CHECK(seed.seed_format);
  CHECK_FALSE(twin.seed_format);
  CHECK(seed.scene == twin.scene);
  CHECK(seed.settings == twin.settings);
  CHECK(seed.scene.materials.size() == 3);
  CHECK(seed.scene.spheres[2].material == 0);
  CHECK_FALSE(std::signbit(seed.scene.spheres[0].center.y));
}

TEST_CASE("a file with an empty list of spheres and nothing else has the seed format") {
  const SceneFile file = read_scene_text(R"({"spheres": []})");
  CHECK(file.seed_format);
  CHECK(file.scene.camera.tan_half_vfov > 0);
}

TEST_CASE("reader and schema agree: what both accept") {
  const Json cases = scene_cases();
  for (const Json& one : cases["good"]) {
    CAPTURE(one["name"].get<std::string>());
    CHECK(message_of_scene(text_of(cases, one)) == "no error");
  }
}

TEST_CASE("reader and schema agree: what both refuse") {
  const Json cases = scene_cases();
  REQUIRE(cases["bad"].size() > 50);
  for (const Json& one : cases["bad"]) {
    CAPTURE(one["name"].get<std::string>());
    const std::string message = message_of_scene(text_of(cases, one));
    CAPTURE(message);
    CHECK(message.find(one["says"].get<std::string>()) != std::string::npos);
    CHECK(message.starts_with("s.json:1: /"));
  }
}

TEST_CASE("every scene that ships loads") {
  std::size_t count = 0;
  for (const auto& entry : std::filesystem::directory_iterator(PARRAY_SOURCE_DIR "/scenes")) {
    if (entry.path().extension() != ".json") continue;
    CAPTURE(entry.path().string());
    CHECK_NOTHROW(read_scene_file(entry.path()));
    ++count;
  }
  CHECK(count >= 9);
  const auto one_weekend = read_scene_file(PARRAY_SOURCE_DIR "/scenes/one-weekend-484.json");
  CHECK(one_weekend.scene.spheres.size() == 484);
  Camera usual;
  usual.tan_half_vfov = one_weekend.scene.camera.tan_half_vfov;
  CHECK(one_weekend.scene.camera == usual);
  CHECK(one_weekend.settings == RenderSettings{});
}

TEST_CASE("200 000 spheres are read as a stream") {
  std::string text = R"({"version": 1, "camera": {"look_from": [0, 0, 9], "look_at": [0, 0, 0],
    "vfov": 40}, "spheres": [)";
  constexpr int count = 200'000;
  for (int i = 0; i < count; ++i) {
    text += (i == 0 ? "\n" : ",\n") + std::string(R"({"center": [)") + std::to_string(i) +
            R"(, 0.5, -1], "radius": 0.25, "material": "m)" + std::to_string(i % 1000) + "\"}";
  }
  text += "],\n\"materials\": {";
  for (int i = 0; i < 1000; ++i) {
    text += (i == 0 ? "" : ",") + ("\"m" + std::to_string(i)) +
            R"(": {"type": "metal", "albedo": [0, 0, 1], "fuzz": )" + std::to_string(i % 500) +
            "e-3}";
  }
  const SceneFile file = read_scene_text(text + "}}");
  REQUIRE(file.scene.spheres.size() == count);
  CHECK(file.scene.materials.size() == 500);
  CHECK(file.scene.spheres.back().center == Vec3d{count - 1, 0.5, -1});
  CHECK(file.scene.materials[file.scene.spheres.back().material].fuzz == 0.499);
  // The line of the last sphere: two lines come before the first.
  text.insert(text.rfind("0.25"), "-");
  CHECK(message_of_scene(text + "}}").starts_with("s.json:200002: /spheres/199999/radius: -0.25"));
}

}  // namespace parray
