#include <doctest/doctest.h>

#include <cmath>
#include <cstdint>
#include <limits>
#include <random>
#include <sstream>
#include <stdexcept>
#include <vector>

#include "cli/input/scene_file/scene_file.h"
#include "cli/input/scene_file/scene_sections.h"
#include "common/base/error.h"
#include "common/scene/limits.h"
#include "common/scene/scene_bytes.h"
#include "common/scene/settings.h"
#include "tests/support/message_of.h"
#include "tests/support/rooms.h"
#include "tests/support/sample_scenes.h"
#include "tests/support/scene_text.h"

namespace parray {
namespace {

using test::read_scene_text;

std::string written(const SceneFile& file) {
  std::ostringstream out;
  write_scene(out, file, [] {});
  return out.str();
}

}  // namespace

TEST_CASE("every scene that ships reads back as itself, settings and names included") {
  for (const char* name : {"one-weekend-484", "glass", "shells", "furnace", "cavity"}) {
    CAPTURE(name);
    const SceneFile file =
        read_scene_file(std::string(PARRAY_SOURCE_DIR "/scenes/") + name + ".json");
    const SceneFile again = read_scene_text(written(file));
    CHECK(scene_to_bytes(again.scene) == scene_to_bytes(file.scene));
    CHECK(again.settings == file.settings);
    CHECK(written(again) == written(file));
    const auto names = again.materials.defined();
    const auto expected = file.materials.defined();
    REQUIRE(names.size() == expected.size());
    for (const NamedMaterial& material : expected) {
      REQUIRE(again.materials.find(std::string(material.name)) != nullptr);
      CHECK(*again.materials.find(std::string(material.name)) == material.material);
    }
  }
}

TEST_CASE("a scene in the seed format is written as version 1") {
  const SceneFile seed = read_scene_text(R"({"spheres": [
    {"sphere": {"location": {"x": 0, "y": 1, "z": 2}, "radius": 0.1,
                "material": {"type": "lambertian", "color": {"r": 0.1, "g": 0.2, "b": 0.3}}}},
    {"sphere": {"radius": 1.0, "location": {"x": 1, "y": 2, "z": 3},
                "material": {"type": "dielectric", "refraction_index": 1.5}}}]})");
  const SceneFile again = read_scene_text(written(seed));
  CHECK(seed.seed_format);
  CHECK_FALSE(again.seed_format);
  CHECK(again.scene == seed.scene);
  CHECK(again.settings == seed.settings);
}

TEST_CASE("a scene's labels read back equal, and a scene without labels has no such section") {
  SceneFile file;
  file.scene = test::small_scene();
  CHECK(written(file).find("labels") == std::string::npos);
  file.labels.legend = file.labels.scale_bar = file.labels.time_stamp = file.labels.cell = true;
  file.labels.text = "Caf\u00e9 \"7\"\nline";
  file.labels.unit = "angstrom";
  file.labels.font_size = 7.5;
  file.labels.dpi = 600;
  CHECK(read_scene_text(written(file)).labels == file.labels);
  file.labels = {};
  file.labels.width_mm = 85.5;
  CHECK(read_scene_text(written(file)).labels == file.labels);
}

TEST_CASE("numbers of every size read back to the last bit") {
  std::mt19937_64 random(1);
  SceneFile file;
  file.scene = test::small_scene();
  file.scene.camera.tan_half_vfov = tan_half_of(file.scene.camera.vfov);
  file.scene.spheres.clear();
  for (int i = 0; i < 20'000; ++i) {
    const auto number = [&](double lowest, double highest) {
      const double exponent = std::uniform_real_distribution<>(lowest, highest)(random);
      return std::pow(10, exponent) * ((random() & 1) != 0 ? 1 : -1);
    };
    file.scene.spheres.push_back(
        {{number(-300, 15), number(-20, 15), number(-2, 2)},
         std::abs(number(-14.9, 14.9)),
         static_cast<std::uint32_t>(file.scene.spheres.size() % file.scene.materials.size())});
  }
  for (const Sphere& sphere :
       std::vector<Sphere>(file.scene.spheres.begin(), file.scene.spheres.begin() + 100)) {
    file.scene.capsules.push_back(
        {sphere.center, file.scene.spheres[200].center, sphere.radius, sphere.material});
  }
  file.scene.spheres[0].center = {5e-324, -limits::max_length, limits::max_length};
  file.settings->seed = UINT64_MAX;
  const SceneFile again = read_scene_text(written(file));
  CHECK(scene_to_bytes(again.scene) == scene_to_bytes(file.scene));
  CHECK(again.settings == file.settings);
}

TEST_CASE("names of materials are kept, and generated names differ from them") {
  SceneFile file = read_scene_text(R"({"version": 1,
    "camera": {"look_from": [0, 0, 9], "look_at": [0, 0, 0], "vfov": 40},
    "materials": {"\"\\\n\u0001 é": {"type": "dielectric", "ior": 1.5}, "": {"type": "dielectric",
      "ior": 1.25}, "material 1": {"type": "metal", "albedo": [1, 0, 1], "fuzz": 0.5}},
    "spheres": [{"center": [0, 0, 0], "radius": 1, "material": "\"\\\n\u0001 é"}]})");
  file.scene.materials.push_back({MaterialType::diffuse, {0.125, 0.25, 0.5}, 0, 1});
  file.scene.spheres.push_back({{1, 2, 3}, 4, 1});
  const SceneFile again = read_scene_text(written(file));
  CHECK(again.scene == file.scene);
  CHECK(again.materials.find("material 1")->type == MaterialType::metal);
  CHECK(again.materials.find("\"\\\n\x01 é") != nullptr);
  CHECK(again.materials.find("") != nullptr);
}

TEST_CASE("files of particles stay references") {
  const std::string section = R"("particles": [
{"file":"a \"b\".xyz"},
{"file":"../c.csv", "material":"gold", "radius":0.1},
{"file":"d.pdb", "material":"by-element", "radius":"by-element"},
{"file":"e.ply", "material":"column", "radius":"column"},
{"file":"f.dump", "frame":7, "material":"by-type", "radius":1e-15}]}
)";
  const std::string text = written(read_scene_text(R"({"version": 1,
    "camera": {"look_from": [0, 0, 9], "look_at": [0, 0, 0], "vfov": 40}, )" +
                                                   section));
  CHECK(text.ends_with(section));
  CHECK(written(read_scene_text(text)) == text);
}

TEST_CASE("an orthographic camera and a transparent background read back as themselves") {
  const std::string camera =
      R"("projection":"orthographic", "view_height":0.1, "aperture":0.25, "focus_distance":9})";
  const SceneFile file =
      read_scene_text(R"({"version": 1,
    "camera": {"look_from": [0, 0, 9], "look_at": [0, 0, 0], )" +
                      camera + R"(, "image": {"transparent": true}, "spheres": [],
    "materials": {}})");
  CHECK(file.scene.camera.projection == Projection::orthographic);
  CHECK(file.scene.camera.view_height == 0.1);
  CHECK(file.scene.camera.vfov == 0);
  CHECK(file.transparent);
  const std::string text = written(file);
  CHECK(text.find(camera) != std::string::npos);
  CHECK(read_scene_text(text).scene == file.scene);
  CHECK(read_scene_text(text).transparent);
  CHECK(written(read_scene_text(text)) == text);
}

TEST_CASE("a name that is not UTF-8 is refused, not written") {
  SceneFile file;
  file.particles.push_back({.file = "\xFF.xyz"});
  CHECK(test::message_of<InputError>([&] { (void)written(file); }) ==
        "'\\xff.xyz' is not UTF-8, but all names and texts in a scene must be: change it");
}

TEST_CASE("the caller can stop the writing") {
  SceneFile file;
  file.scene.materials.emplace_back();
  file.scene.spheres.resize(100'000);
  std::ostringstream out;
  int left = 5;
  const auto poll = [&] {
    if (--left == 0) throw std::runtime_error("enough");
  };
  CHECK_THROWS_WITH(write_scene(out, file, poll), "enough");
  CHECK(out.str().size() < 2'000'000);
}

}  // namespace parray
