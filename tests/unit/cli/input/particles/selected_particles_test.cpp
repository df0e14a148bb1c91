#include "cli/input/particles/selected_particles.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "cli/input/particles/elements.h"
#include "cli/input/particles/particle_spheres.h"
#include "cli/input/view/auto_scene.h"
#include "cli/output/picture/partial_file.h"
#include "common/base/error.h"
#include "common/scene/settings.h"
#include "tests/support/message_of.h"
#include "tests/support/rooms.h"
#include "tests/support/temporary_directory.h"

/// The section `particles` of a scene: which spheres it adds, and what it refuses.
namespace parray {
namespace {

using test::message_of;

/// A scene of version 1 with one sphere and three materials, and files of particles beside it.
class ParticleScene {
 public:
  ParticleScene() {
    write("atoms.xyz", "3\n\nO 1 2 3\nH -0.0 0 0\nH 0 1 0\n");
    write("grains.csv", "x,y,z,radius,red,green,blue\n1,0,0,0.5,1,0,0.25\n2,0,0,0.25,0,1,0\n");
    write("types.csv", "x,y,z,type\n0,0,0,gold\n1,0,0,sand\n2,0,0,clay\n3,0,0,gold\n");
    write("points.csv", "x,y,z\n1,2,3\n");
  }

  void write(const std::string& name, const std::string& text) const {
    write_text_file(directory_.path() / name, text);
  }
  [[nodiscard]] std::string scene() const { return (directory_.path() / "scene.json").string(); }
  [[nodiscard]] std::string file(const std::string& name) const {
    return (directory_.path() / name).string();
  }

  [[nodiscard]] Scene expanded(const std::string& particles) const {
    write("scene.json", R"({"version": 1,
"camera": {"look_from": [0, 0, 9], "look_at": [0, 0, 0], "vfov": 40},
"materials": {"ground": {"type": "diffuse", "albedo": [0.5, 0.5, 0.5]},
 "gold": {"type": "metal", "albedo": [0.8, 0.6, 0.2]}, "glass": {"type": "dielectric", "ior": 1.5}},
"spheres": [{"center": [0, -100, 0], "radius": 100, "material": "ground"}],
"particles": [
)" + particles + "]}");
    SceneFile file = read_scene_file(scene());
    CHECK(file.scene.spheres.size() == 1);
    expand_particles(file, scene());
    CHECK(file.particles.empty());
    return file.scene;
  }

  /// What is wrong with the section, without the name of the scene file.
  [[nodiscard]] std::string refusal(const std::string& particles) const {
    const std::string message = message_of<InputError>([&] { (void)expanded(particles); });
    REQUIRE(message.starts_with(scene() + ":"));
    return message.substr(scene().size() + 1);
  }

 private:
  test::TemporaryDirectory directory_;
};

Material diffuse(const Vec3d& albedo) { return {MaterialType::diffuse, albedo, 0, 1}; }

const Material gold_metal{MaterialType::metal, {0.8, 0.6, 0.2}, 0, 1};

}  // namespace

TEST_CASE("particles come after the spheres, in the order of files and lines") {
  const ParticleScene files;
  const Scene scene = files.expanded(R"({"file": "atoms.xyz", "material": "gold", "radius": 0.5},
    {"file": "points.csv", "material": "ground", "radius": 2})");
  CHECK(scene.spheres == std::vector<Sphere>{{{0, -100, 0}, 100, 0},
                                             {{1, 2, 3}, 0.5, 1},
                                             {{0, 0, 0}, 0.5, 1},
                                             {{0, 1, 0}, 0.5, 1},
                                             {{1, 2, 3}, 2, 0}});
  CHECK_FALSE(std::signbit(scene.spheres[2].center.x));  // -0 in the file
  CHECK(scene.materials == std::vector<Material>{diffuse({0.5, 0.5, 0.5}), gold_metal});
}

TEST_CASE("by-element takes colour and radius from the table of elements") {
  const ParticleScene files;
  const Scene scene =
      files.expanded(R"({"file": "atoms.xyz", "material": "by-element", "radius": "by-element"})");
  CHECK(scene.materials == std::vector<Material>{diffuse({0.5, 0.5, 0.5}),
                                                 diffuse(element(8).color),
                                                 diffuse(element(1).color)});
  CHECK(scene.spheres[1] == Sphere{{1, 2, 3}, element(8).radius, 1});
  CHECK(scene.spheres[2] == Sphere{{0, 0, 0}, element(1).radius, 2});
  CHECK(scene.spheres[3] == Sphere{{0, 1, 0}, element(1).radius, 2});
}

TEST_CASE("column takes colour and radius from the file") {
  const ParticleScene files;
  const Scene scene =
      files.expanded(R"({"file": "grains.csv", "material": "column", "radius": "column"})");
  CHECK(scene.spheres[1] == Sphere{{1, 0, 0}, 0.5, 1});
  CHECK(scene.spheres[2] == Sphere{{2, 0, 0}, 0.25, 2});
  CHECK(scene.materials ==
        std::vector<Material>{diffuse({0.5, 0.5, 0.5}), diffuse({1, 0, 0.25}), diffuse({0, 1, 0})});
}

TEST_CASE("by-type takes the material with the type's name, or a colour for the type") {
  const ParticleScene files;
  const Scene scene =
      files.expanded(R"({"file": "types.csv", "material": "by-type", "radius": 1})");
  REQUIRE(scene.materials.size() == 4);
  CHECK(scene.materials[1] == gold_metal);
  const Material sand = scene.materials[2];
  const Material clay = scene.materials[3];
  CHECK(sand.type == MaterialType::diffuse);
  CHECK(clay.type == MaterialType::diffuse);
  CHECK_FALSE(sand == clay);
  CHECK(scene.spheres[1].material == 1);
  CHECK(scene.spheres[2].material == 2);
  CHECK(scene.spheres[3].material == 3);
  CHECK(scene.spheres[4].material == 1);
}

TEST_CASE("the default is the first of column, by-element and by-type that the file supports") {
  const ParticleScene files;
  CHECK(
      files.expanded(R"({"file": "atoms.xyz"})") ==
      files.expanded(R"({"file": "atoms.xyz", "material": "by-element", "radius": "by-element"})"));
  CHECK(files.expanded(R"({"file": "grains.csv"})") ==
        files.expanded(R"({"file": "grains.csv", "material": "column", "radius": "column"})"));
  CHECK(files.expanded(R"({"file": "types.csv", "radius": 3})") ==
        files.expanded(R"({"file": "types.csv", "material": "by-type", "radius": 3})"));
}

TEST_CASE("equal materials of spheres, names and columns become one") {
  const ParticleScene files;
  files.write("grey.csv", "x,y,z,r,g,b\n0,0,0,0.5,0.5,0.5\n1,0,0,0.5,0.5,0.5\n");
  const Scene scene = files.expanded(R"({"file": "grey.csv", "material": "ground", "radius": 1},
    {"file": "types.csv", "material": "gold", "radius": 1},
    {"file": "types.csv", "material": "gold", "radius": 1})");
  CHECK(scene.materials == std::vector<Material>{diffuse({0.5, 0.5, 0.5}), gold_metal});
}

TEST_CASE("a missing column is refused with the list of columns") {
  const ParticleScene files;
  const auto refusal = [&](const std::string& text) { return files.refusal("\n" + text); };
  CHECK(refusal(R"({"file": "atoms.xyz", "material": "column"})") ==
        "8: /particles/0/material: atoms.xyz has no colours: use by-element, by-type or the name "
        "of a material");
  CHECK(refusal(R"({"file": "types.csv", "material": "by-element", "radius": 1})") ==
        "8: /particles/0/material: types.csv has no elements: use by-type or the name of a "
        "material");
  CHECK(refusal(R"({"file": "grains.csv", "material": "by-type"})") ==
        "8: /particles/0/material: grains.csv has no types: use column or the name of a material");
  CHECK(refusal("{\"file\": \"points.csv\",\n\"radius\": 1}") ==
        "8: /particles/0/material: points.csv has no colours, elements or types: use the name of a "
        "material");
  CHECK(refusal("{\"file\": \"atoms.xyz\",\n\"radius\": \"column\"}") ==
        "9: /particles/0/radius: atoms.xyz has no radii: use by-element or a number");
  CHECK(refusal(R"({"file": "grains.csv", "radius": "by-element"})") ==
        "8: /particles/0/radius: grains.csv has no elements: use column or a number");
  CHECK(refusal(R"({"file": "types.csv"})") ==
        "8: /particles/0/radius: types.csv has no radii or elements: use a number");
}

TEST_CASE("an unknown material of particles is refused with the nearest known word") {
  const ParticleScene files;
  CHECK(files.refusal(R"({"file": "atoms.xyz"}, {"file": "atoms.xyz", "material": "glas"})") ==
        "7: /particles/1/material: unknown material 'glas': did you mean 'glass'?");
  CHECK(files.refusal(R"({"file": "atoms.xyz", "material": "by-elment"})") ==
        "7: /particles/0/material: unknown material 'by-elment': did you mean 'by-element'?");
  CHECK(files.refusal(R"({"file": "atoms.xyz", "material": "x"})") ==
        "7: /particles/0/material: unknown material 'x': write by-element, by-type, column or the "
        "name of a material");
}

TEST_CASE("a particle file that cannot be read is refused with its own place and the scene's") {
  const ParticleScene files;
  files.write("bad.xyz", "1\n\nH 0 0\n");
  CHECK(files.refusal(R"({"file": "no-such.xyz"})")
            .starts_with("7: /particles/0/file: " + files.file("no-such.xyz") + ": no such file"));
  CHECK(files.refusal(R"({"file": "bad.xyz"})")
            .starts_with("7: /particles/0/file: " + files.file("bad.xyz") + ":3: "));
  CHECK(files.refusal(R"({"file": "picture.png"})").starts_with("7: /particles/0/file: "));
}

TEST_CASE("names of particle files are relative to the scene's folder, or absolute") {
  const ParticleScene files;
  const Scene expected = files.expanded(R"({"file": "atoms.xyz"})");
  const std::string folder = std::filesystem::path(files.scene()).parent_path().filename();
  CHECK(files.expanded(R"({"file": "../)" + folder + R"(/atoms.xyz"})") == expected);
  CHECK(files.expanded(R"({"file": ")" + files.file("atoms.xyz") + R"("})") == expected);
}

TEST_CASE("memory for spheres is reserved exactly") {
  Particles particles;
  particles.positions.resize(1000);
  const ParticleLook look{.material = {ParticleMaterial::Rule::named, "stone"},
                          .radius = {ParticleRadius::Rule::fixed, 1}};
  MaterialNames names;
  names.define("stone", diffuse({1, 1, 1}));
  Scene scene;
  scene.spheres.resize(7);
  append_spheres(std::move(particles), {}, look, "some.ply", names, scene);
  CHECK(scene.spheres.size() == 1007);
  CHECK(scene.spheres.capacity() == 1007);
}

TEST_CASE("an automatic scene contains ground, light blocker and particles") {
  const ParticleScene files;
  const AutoScene atoms = auto_scene(files.file("atoms.xyz"), {}, auto_scene_settings());
  CHECK(atoms.file.settings->width == 1200);
  CHECK(atoms.file.settings->height == 900);
  CHECK(atoms.file.settings->samples_per_pixel == 256);
  CHECK(atoms.file.settings->max_depth == 10);
  REQUIRE(atoms.file.scene.spheres.size() == 5);
  CHECK(atoms.file.scene.spheres[2] == Sphere{{1, 2, 3}, element(8).radius, 2});
  CHECK(atoms.source.look.material.rule == ParticleMaterial::Rule::by_element);
  CHECK(atoms.source.look.radius.rule == ParticleRadius::Rule::by_element);
}

TEST_CASE("radii of elements are in the file's unit of length, in spheres and in balls of sticks") {
  const ParticleScene files;
  const auto shown_radius = [&](const std::string& unit, const ParticleLook& look) {
    std::string text = "element,x,y,z\nAr,0,0,0\nAr,0,0,4\n";
    for (const char* const axis : {",x", ",y", ",z"}) {
      text.insert(text.find(axis) + 2, " [" + unit + "]");
    }
    files.write("pair.csv", text);
    ParticleSource source;
    source.look = look;
    return auto_scene(files.file("pair.csv"), source, auto_scene_settings())
        .file.scene.spheres.back()
        .radius;
  };
  using Rule = ParticleRadius::Rule;
  for (const auto& [rule, style] : {std::pair(Rule::by_element, ParticleStyle::spheres),
                                    std::pair(Rule::covalent, ParticleStyle::spheres),
                                    std::pair(Rule::by_element, ParticleStyle::balls_and_sticks)}) {
    ParticleLook look;
    look.style = style;
    look.radius = {rule, 0};
    const double in_angstrom = shown_radius("angstrom", look);
    CHECK(shown_radius("nm", look) == doctest::Approx(in_angstrom / 10));
    CHECK(shown_radius("px", look) == in_angstrom);
  }
}

TEST_CASE("points become plain balls with the lattice radius") {
  const ParticleScene files;
  files.write("pair.csv", "x,y,z\n0,0,0\n0,0,4\n");
  const AutoScene pair = auto_scene(files.file("pair.csv"), {}, auto_scene_settings());
  CHECK(pair.source.look.material.name == "plain");
  CHECK(pair.source.look.radius.rule == ParticleRadius::Rule::fixed);
  CHECK(pair.source.look.radius.value == doctest::Approx(2));
  CHECK(pair.file.scene.spheres[2].radius == pair.source.look.radius.value);
  CHECK(pair.file.scene.spheres[3].radius == pair.source.look.radius.value);
}

TEST_CASE("an automatic scene with missing columns is refused") {
  const ParticleScene files;
  const auto refusal = [&](const std::string& name, const char* material, const char* radius) {
    return message_of<InputError>([&] {
      ParticleSource source;
      source.look.material = particle_material_from(material);
      source.look.radius = particle_radius_from(radius);
      (void)auto_scene(files.file(name), source, auto_scene_settings());
    });
  };
  CHECK(refusal("points.csv", "column", "column") ==
        files.file("points.csv") + " has no colours: use plain");
  CHECK(refusal("grains.csv", "by-type", "column") ==
        files.file("grains.csv") + " has no types: use column or plain");
  CHECK(refusal("atoms.xyz", "plain", "column") ==
        files.file("atoms.xyz") + " has no radii: use by-element or a number");
}

TEST_CASE("a column with the name of a fraction of the cell is not used, and a note says so") {
  const ParticleScene files;
  files.write("forces.csv", "x,y,z,fx [N],fy,fz\n0,0,0,5,0,0\n1,0,0,-3,1,0\n4,2,0,0,0,7\n");
  ParticleSource source;
  source.look.coloring.by = "fx";
  source.arrows = "force";
  const AutoScene scene = auto_scene(files.file("forces.csv"), source, auto_scene_settings());
  const std::vector<Legend>& legends = scene.file.legends;
  const auto legend = std::ranges::find(legends, "fx", &Legend::title);
  REQUIRE(legend != legends.end());
  CHECK(legend->low == 0);
  CHECK(legend->high == 1);
  CHECK(legend->unit.empty());
  const std::vector<ParticleNote>& notes = scene.file.particle_files[0].facts.notes;
  REQUIRE(notes.size() == 1);
  CHECK(notes[0].count == 3);
  CHECK(notes[0].text ==
        "particles with a column fx that is not used: fx is a fraction of the cell");
  source.look.coloring.by = "x";
  source.filter.slice = "x=0%:100%";
  const AutoScene sliced = auto_scene(files.file("forces.csv"), source, auto_scene_settings());
  CHECK(sliced.file.particle_files[0].facts.notes.empty());
}

}  // namespace parray
