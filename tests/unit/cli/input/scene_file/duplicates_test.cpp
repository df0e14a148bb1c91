#include "cli/input/scene_file/duplicates.h"

#include <doctest/doctest.h>

#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "cli/input/scene_file/scene_file.h"
#include "common/scene/scene_bytes.h"
#include "common/scene/settings.h"
#include "tests/support/dice.h"
#include "tests/support/rooms.h"
#include "tests/support/sample_scenes.h"
#include "tests/support/scene_text.h"

namespace parray::test {
namespace {

Scene with_spheres(std::vector<Sphere> spheres) {
  Scene scene = small_scene();
  scene.spheres = std::move(spheres);
  return scene;
}

bool same(const Sphere& a, const Sphere& b) { return a.center == b.center && a.radius == b.radius; }

SceneFile read_spheres(const std::string& spheres) {
  return read_scene_text(R"({"version": 1,
    "camera": {"look_from": [0, 0, 9], "look_at": [0, 0, 0], "vfov": 40},
    "materials": {"a": {"type": "diffuse", "albedo": [1, 0, 0]},
                  "b": {"type": "diffuse", "albedo": [0, 1, 0]},
                  "c": {"type": "dielectric", "ior": 1.5}},
    "spheres": [)" + spheres +
                         "]}");
}

std::string sphere(const char* material, int x) {
  return R"({"center": [)" + std::to_string(x) + R"(, 0, 0], "radius": 1, "material": ")" +
         material + "\"}";
}

constexpr std::uint32_t diffuse = 0;  // materials of small_scene()
constexpr std::uint32_t metal = 1;
constexpr std::uint32_t glass = 2;

/// A ground, and before it one sphere for each of these materials, all in one place.
Scene in_one_place(const std::vector<std::uint32_t>& materials) {
  Scene scene = with_spheres({{{0, -1000, 0}, 1000, diffuse}});
  for (const std::uint32_t material : materials) scene.spheres.push_back({{0, 1, 0}, 1, material});
  return scene;
}

std::string picture_of(const Scene& scene) {
  RenderSettings settings = small_settings(small_scene());
  settings.precision = Precision::f64;
  return reference_sha256(scene, settings);
}

}  // namespace

TEST_CASE("of equal spheres the first stays, for any materials") {
  const std::vector<Sphere> spheres{{{1, 2, 3}, 1, metal},   {{1, 2, 3}, 2, metal},
                                    {{4, 5, 6}, 1, diffuse}, {{1, 2, 3}, 2, metal},
                                    {{1, 2, 3}, 1, glass},   {{1, 2, 3}, 2, diffuse}};
  Scene scene = with_spheres(spheres);
  const std::vector<Material> materials = scene.materials;
  const Duplicates duplicates = remove_duplicates(scene);
  CHECK(duplicates.count == 3);
  CHECK(duplicates.first == 3);
  CHECK(duplicates.first_of == 1);
  REQUIRE(scene.spheres.size() == 3);
  for (std::size_t i = 0; i < 3; ++i) {
    CHECK(same(scene.spheres[i], spheres[i]));
    CHECK(scene.materials[scene.spheres[i].material] == materials[spheres[i].material]);
  }
  CHECK(scene.materials == std::vector<Material>{materials[metal], materials[diffuse]});
  CHECK(remove_duplicates(scene).count == 0);
}

TEST_CASE("spheres that differ in one bit all stay, and the scene does not change") {
  const auto next = [](double x) { return std::nextafter(x, 2e15); };
  Scene scene = with_spheres({{{0.1, 0.2, 0.3}, 0.4, 3},
                              {{next(0.1), 0.2, 0.3}, 0.4, 3},
                              {{0.1, next(0.2), 0.3}, 0.4, 3},
                              {{0.1, 0.2, next(0.3)}, 0.4, 3},
                              {{0.1, 0.2, 0.3}, next(0.4), 3},
                              {{0.2, 0.1, 0.3}, 0.4, 3},
                              {{-0.1, 0.2, 0.3}, 0.4, 3}});
  const Scene before = scene;
  CHECK(remove_duplicates(scene).count == 0);
  CHECK(scene == before);  // materials that nobody uses, too
}

TEST_CASE("materials get the order of first use, by spheres and then by capsules") {
  Scene scene = with_spheres({{{0, 0, 0}, 1, glass}, {{3, 0, 0}, 1, diffuse}});
  const std::vector<Material> materials = scene.materials;
  scene.capsules = {{{0, 3, 0}, {1, 3, 0}, 1, metal}, {{0, 6, 0}, {1, 6, 0}, 1, diffuse}};
  order_materials(scene);
  CHECK(scene.materials ==
        std::vector<Material>{materials[glass], materials[diffuse], materials[metal]});
  CHECK(scene.spheres[0].material == 0);
  CHECK(scene.spheres[1].material == 1);
  CHECK(scene.capsules[0].material == 2);
  CHECK(scene.capsules[1].material == 1);
}

TEST_CASE("0 and -0 are equal") {
  Scene scene = with_spheres({{{0, -0.0, 0}, 1, 0}, {{-0.0, 0, -0.0}, 1, 0}});
  CHECK(remove_duplicates(scene).count == 1);
  CHECK(std::signbit(scene.spheres[0].center.y));
}

TEST_CASE("no spheres, no duplicates") {
  Scene scene = with_spheres({});
  CHECK(remove_duplicates(scene).count == 0);
  CHECK(scene == with_spheres({}));
}

TEST_CASE("the result equals a comparison of all pairs") {
  Dice dice(1);
  for (int round = 0; round < 200; ++round) {
    std::vector<Sphere> spheres(dice.below(100));
    const std::uint64_t places = 1 + dice.below(6);
    for (Sphere& one : spheres) {
      const auto coordinate = [&] { return static_cast<double>(dice.below(places)); };
      const double x = coordinate();
      const double y = coordinate();
      one = {{x, y, coordinate()}, 1 + coordinate(), dice.below32(4)};
    }
    std::vector<Sphere> expected;
    for (const Sphere& one : spheres) {
      bool known = false;
      for (const Sphere& other : expected) known = known || same(one, other);
      if (!known) expected.push_back(one);
    }
    Scene scene = with_spheres(spheres);
    const Duplicates duplicates = remove_duplicates(scene);
    CHECK(duplicates.count == spheres.size() - expected.size());
    REQUIRE(scene.spheres.size() == expected.size());
    for (std::size_t i = 0; i < expected.size(); ++i) CHECK(same(scene.spheres[i], expected[i]));
    if (duplicates.count > 0) {
      CHECK(duplicates.first_of < duplicates.first);
      CHECK(same(spheres[duplicates.first], spheres[duplicates.first_of]));
    }
  }
}

TEST_CASE("a scene file with duplicates gives the scene, and the identity, of one without") {
  const SceneFile clean =
      read_spheres(sphere("a", 0) + "," + sphere("c", 2) + "," + sphere("b", 4));
  CHECK(clean.duplicates.count == 0);
  const SceneFile file = read_spheres(sphere("a", 0) + "," + sphere("b", 0) + "," + sphere("c", 2) +
                                      "," + sphere("b", 4) + "," + sphere("c", 4));
  CHECK(file.duplicates.count == 2);
  CHECK(file.duplicates.first == 1);
  CHECK(file.duplicates.first_of == 0);
  CHECK(file.scene == clean.scene);
  CHECK(scene_to_bytes(file.scene) == scene_to_bytes(clean.scene));
}

TEST_CASE("removing what repeats a diffuse or metal sphere changes no pixel") {
  for (const std::uint32_t first : {diffuse, metal}) {
    for (const std::uint32_t second : {diffuse, metal, glass}) {
      CAPTURE(first);
      CAPTURE(second);
      const std::string alone = picture_of(in_one_place({first}));
      CHECK(picture_of(in_one_place({first, second})) == alone);
      if (first != second) CHECK(picture_of(in_one_place({second, first})) != alone);
      Scene scene = in_one_place({first, second, second});
      CHECK(remove_duplicates(scene).count == 2);
      CHECK(picture_of(scene) == alone);
    }
  }
}

TEST_CASE("glass in one place counts once: it refracts as one sphere, with its copy and without") {
  Scene twice = in_one_place({glass, glass});
  const std::string alone = picture_of(in_one_place({glass}));
  CHECK(picture_of(twice) == alone);
  CHECK(remove_duplicates(twice).count == 1);
  CHECK(picture_of(twice) == alone);
}

TEST_CASE("a grid of a million spheres, each twice, loses its copies") {
  std::vector<Sphere> spheres;
  constexpr int side = 100;
  for (int copy = 0; copy < 2; ++copy) {
    for (int x = 0; x < side; ++x) {
      for (int y = 0; y < side; ++y) {
        for (int z = 0; z < side; ++z) spheres.push_back({{1.0 * x, 1.0 * y, 1.0 * z}, 0.5, 0});
      }
    }
  }
  Scene scene = with_spheres(std::move(spheres));
  CHECK(remove_duplicates(scene).count == side * side * side);
  CHECK(scene.spheres.size() == side * side * side);
}

}  // namespace parray::test
