#include <doctest/doctest.h>

#include <algorithm>
#include <sstream>
#include <string>

#include "cli/input/particles/elements.h"
#include "cli/input/particles/selected_particles.h"
#include "cli/input/scene_file/scene_file.h"
#include "cli/input/view/auto_scene.h"
#include "cli/output/picture/partial_file.h"
#include "common/base/error.h"
#include "tests/support/message_of.h"
#include "tests/support/rooms.h"
#include "tests/support/temporary_directory.h"

/// Bonds, arrows and cells of particle files, in scene files and in automatic scenes.
namespace parray {
namespace {

using test::message_of;

constexpr const char* water_sdf =
    "water\n\n\n  3  2  0  0  0  0  0  0  0  0999 V2000\n"
    "    0.0000    0.0000    0.0000 O   0  0\n"
    "    1.0000    0.0000    0.0000 H   0  0\n"
    "    0.0000    1.0000    0.0000 H   0  0\n"
    "  1  2  1  0\n  1  3  1  0\nM  END\n$$$$\n";

/// A folder with files of particles.
class Files {
 public:
  Files() {
    write("water.sdf", water_sdf);
    write("moving.xyz",
          "2\nLattice=\"14 0 0 0 15 0 0 0 16\" "
          "Properties=species:S:1:pos:R:3:velo:R:3:charge:R:1\n"
          "Ar 1 1 1 0 0 3 1\nAr 8 1 1 0 1 0 2\n");
    write("points.csv", "x,y,z,charge\n1,2,3,1\n2,2,3,1\n");
  }
  void write(const std::string& name, const std::string& text) const {
    write_text_file(directory_.path() / name, text);
  }
  [[nodiscard]] std::string path(const std::string& name) const {
    return (directory_.path() / name).string();
  }

  /// Returns the scene of an item of `particles`, which has no other shapes.
  [[nodiscard]] SceneFile expanded(const std::string& item) const {
    write("scene.json", R"({"version": 1,
"camera": {"look_from": [0, 0, 9], "look_at": [0, 0, 0], "vfov": 40},
"particles": [)" + item + "]}");
    SceneFile file = read_scene_file(path("scene.json"));
    expand_particles(file, path("scene.json"));
    return file;
  }
  [[nodiscard]] std::string refusal(const std::string& item) const {
    const std::string message = message_of<InputError>([&] { (void)expanded(item); });
    const std::size_t place = message.find("/particles/0/");
    return place == std::string::npos ? message : message.substr(place + 13);
  }
  [[nodiscard]] AutoScene automatic(const std::string& name, const ParticleSource& source) const {
    return auto_scene(path(name), source, auto_scene_settings());
  }

 private:
  test::TemporaryDirectory directory_;
};

ParticleSource with_style(ParticleStyle style) {
  ParticleSource source;
  source.look.style = style;
  return source;
}

}  // namespace

TEST_CASE("balls and sticks have half sticks in the colours of the atoms, after all balls") {
  const Files files;
  const Scene scene = files.expanded(R"({"file": "water.sdf", "style": "balls-and-sticks"})").scene;
  REQUIRE(scene.spheres.size() == 3);
  CHECK(scene.spheres[0] == Sphere{{0, 0, 0}, 0.25 * element(8).radius, 0});
  CHECK(scene.spheres[1] == Sphere{{1, 0, 0}, 0.25 * element(1).radius, 1});
  CHECK(scene.capsules == std::vector<Capsule>{{{0, 0, 0}, {0.5, 0, 0}, 0.15, 0},
                                               {{1, 0, 0}, {0.5, 0, 0}, 0.15, 1},
                                               {{0, 0, 0}, {0, 0.5, 0}, 0.15, 0},
                                               {{0, 1, 0}, {0, 0.5, 0}, 0.15, 1}});
  CHECK(scene.materials.size() == 2);
}

TEST_CASE("sticks have balls of their own radius") {
  const Files files;
  const Scene scene =
      files.expanded(R"({"file": "water.sdf", "style": "sticks", "stick_radius": 0.2})").scene;
  for (const Sphere& sphere : scene.spheres) CHECK(sphere.radius == 0.2);
  REQUIRE(scene.capsules.size() == 4);
  for (const Capsule& capsule : scene.capsules) CHECK(capsule.radius == 0.2);
}

TEST_CASE("scene files draw spheres unless they ask for sticks, with the spheres of before") {
  const Files files;
  const Scene plain = files.expanded(R"({"file": "water.sdf"})").scene;
  CHECK(plain.capsules.empty());
  CHECK(plain.spheres[0] == Sphere{{0, 0, 0}, element(8).radius, 0});
  CHECK(files.expanded(R"({"file": "water.sdf", "style": "spheres"})").scene == plain);
  CHECK(files.expanded(R"({"file": "water.sdf", "style": "auto"})").scene == plain);
}

TEST_CASE("a bond between representations has each half in the style of its atom") {
  const Files files;
  const auto shown = [&](const std::string& first, const std::string& second) {
    return files
        .expanded(R"({"file": "water.sdf", "show": [{"select": "element H", )" + first +
                  R"(}, {"select": "element O", )" + second + "}]}")
        .scene;
  };
  const Scene both = shown(R"("style": "sticks")",
                           R"("style": "balls-and-sticks", "stick_radius": 0.3, "radius": 0.5)");
  REQUIRE(both.capsules.size() == 4);
  CHECK(both.spheres[2] == Sphere{{0, 0, 0}, 0.5, 1});  // oxygen comes last
  CHECK(both.capsules[0] == Capsule{{0, 0, 0}, {0.5, 0, 0}, 0.3, 1});
  CHECK(both.capsules[1] == Capsule{{1, 0, 0}, {0.5, 0, 0}, 0.15, 0});
  CHECK(shown(R"("style": "sticks")", R"("style": "spheres")").capsules.size() == 2);
  CHECK(files
            .expanded(R"({"file": "water.sdf", "style": "sticks",
                          "show": [{"select": "element H"}]})")
            .scene.capsules.empty());
}

TEST_CASE("an automatic scene of a small molecule has sticks, and its reference says so") {
  const Files files;
  AutoScene water = files.automatic("water.sdf", {});
  CHECK(water.file.scene.capsules.size() == 4);
  CHECK(water.source.look.style == ParticleStyle::balls_and_sticks);
  CHECK(!water.source.look.stick_radius);
  const Scene scene = water.file.scene;
  std::ostringstream out;
  write_scene(out, with_reference(std::move(water), "water.sdf"), [] {});
  CHECK(out.str().find(R"("style":"balls-and-sticks")") != std::string::npos);
  files.write("reference.json", out.str());
  SceneFile again = read_scene_file(files.path("reference.json"));
  CHECK(again.scene.capsules.empty());
  expand_particles(again, files.path("reference.json"));
  CHECK(again.scene == scene);
}

TEST_CASE("an automatic scene with style spheres is that of particles without bonds") {
  const Files files;
  const AutoScene spheres = files.automatic("water.sdf", with_style(ParticleStyle::spheres));
  ParticleSource source;
  source.bonds = BondSource::off;
  CHECK(spheres.file.scene == files.automatic("water.sdf", source).file.scene);
  CHECK(spheres.file.scene.capsules.empty());
}

TEST_CASE("a scene with sticks, arrows and a cell is written and read back to the same bits") {
  const Files files;
  ParticleSource source = with_style(ParticleStyle::sticks);
  source.arrows = "velocity";
  source.arrow_scale = 0.3;
  source.solid_cell = true;
  const SceneFile file = files.automatic("moving.xyz", source).file;
  CHECK(file.scene.capsules.size() == 2 * capsules_of_arrow + 12);
  CHECK(file.solid_cell);
  CHECK(file.legends.size() == 2);
  std::ostringstream out;
  write_scene(out, file, [] {});
  std::istringstream in(out.str());
  CHECK(read_scene(in, "written").scene == file.scene);
}

TEST_CASE("members of an item of particles keep their values in a scene file") {
  const Files files;
  ParticleSource source = with_style(ParticleStyle::sticks);
  source.look.stick_radius = 0.25;
  source.bonds = BondSource::off;
  source.arrows = "velo_x,velo_y,velo_z";
  source.arrow_scale = 2;
  source.solid_cell = true;
  std::ostringstream out;
  write_scene(out, with_reference(files.automatic("moving.xyz", source), "moving.xyz"), [] {});
  std::istringstream in(out.str());
  const ParticleSource read = read_scene(in, "written").particles.at(0);
  CHECK(read.look.style == source.look.style);
  CHECK(read.look.stick_radius == source.look.stick_radius);
  CHECK(read.bonds == source.bonds);
  CHECK(read.arrows == source.arrows);
  CHECK(read.arrow_scale == source.arrow_scale);
  CHECK(read.solid_cell);
}

TEST_CASE("arrows begin at the centres, in the colours of their particles") {
  const Files files;
  const SceneFile file =
      files.expanded(R"({"file": "moving.xyz", "arrows": "velocity", "arrow_scale": 1})");
  REQUIRE(file.scene.capsules.size() == 2 * capsules_of_arrow);
  CHECK(file.scene.capsules[0].from == Vec3d{1, 1, 1});
  CHECK(file.scene.capsules[0].to.z < 4);
  CHECK(file.scene.capsules[0].to.z > 2);
  CHECK(file.scene.capsules[0].material == file.scene.spheres[0].material);
  CHECK(file.scene.capsules[capsules_of_arrow].from == Vec3d{8, 1, 1});
}

TEST_CASE("the picture of an automatic scene contains arrows and the whole solid cell") {
  const Files files;
  ParticleSource source;
  const auto distance = [&] {
    return files.automatic("moving.xyz", source).file.scene.camera.focus_distance;
  };
  source.cell.crystal = false;
  const double bare = distance();
  source.solid_cell = true;
  CHECK(distance() > bare);
  source.solid_cell = false;
  source.arrows = "velocity";
  source.arrow_scale = 100;
  CHECK(distance() > 10 * bare);
}

TEST_CASE("bonds, arrows and cells that a file lacks are refused in one line") {
  const Files files;
  CHECK(files
            .refusal(R"({"file": "points.csv", "radius": 1, "material": "by-type",
                          "bonds": "file"})")
            .starts_with("bonds: the file states no bonds of these particles: use auto or off"));
  CHECK(files.refusal(R"({"file": "moving.xyz", "arrows": "force"})") ==
        "arrows: the file has no vectors 'force': leave out \"arrows\", or name three columns of "
        "the file, separated by commas: velo, velo_x, velo_y, velo_z, charge");
  CHECK(files.refusal(R"({"file": "water.sdf", "solid_cell": true})") ==
        "solid_cell: the file has no box and no cell: leave it out");
  CHECK(files.refusal(R"({"file": "moving.xyz", "arrow_scale": 2})") ==
        "arrow_scale: has no effect without \"arrows\": add it");
  CHECK(files.refusal(R"({"file": "water.sdf", "style": "spheres", "stick_radius": 2})") ==
        "stick_radius: has no effect on \"style\" spheres: leave it out");
  CHECK(files.refusal(R"({"file": "water.sdf", "style": "stick"})") ==
        "style: unknown style of particles 'stick': did you mean 'sticks'?");
  CHECK(files.refusal(R"({"file": "water.sdf", "bonds": "on"})")
            .starts_with("bonds: unknown source of bonds 'on': "));
}

TEST_CASE("sticks without bonds are noted") {
  const Files files;
  const SceneFile file = files.expanded(R"({"file": "moving.xyz", "style": "sticks"})");
  CHECK(file.scene.capsules.empty());
  CHECK(std::ranges::count(file.particle_files.at(0).facts.notes, "no_bonds", &ParticleNote::key) ==
        1);
}

}  // namespace parray
