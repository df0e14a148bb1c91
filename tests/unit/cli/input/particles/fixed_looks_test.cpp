#include "cli/input/particles/fixed_looks.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <fstream>
#include <string>
#include <vector>

#include "cli/input/particles/selected_particles.h"
#include "cli/input/scene_file/scene_file.h"
#include "tests/support/rooms.h"
#include "tests/support/temporary_directory.h"

namespace parray {
namespace {

/// A scene file that names a trajectory in extended XYZ.
class Trajectory {
 public:
  /// `last`: a number in the last frame.
  explicit Trajectory(const std::string& look, const std::string& last = "5") {
    write("a.xyz", frame("b 0 0 0 -1 0\nc 1 0 0 2 0\n") + frame("a 0 0 0 3 0\nb 1 0 0 4 0\n") +
                       frame("c 0 0 0 " + last + " 0\na 1 0 0 -7 0\n"));
    write("s.json", R"({"version": 1,
"camera": {"look_from": [0, 0, 9], "look_at": [0, 0, 0], "vfov": 40},
"particles": [{"file": "a.xyz")" +
                        look + "}]}");
  }

  /// Returns the scene of a frame, with the looks of all frames if `fixed` is true.
  [[nodiscard]] SceneFile at(std::uint64_t number, bool fixed) const {
    FixedLooks looks;
    for (std::uint64_t i = 0; fixed && i < 3; ++i) looks.add(at(i, false).particle_files);
    SceneFile scene = read_scene_file(directory_.path() / "s.json");
    scene.particles[0].frame = FrameChoice{number, false};
    if (fixed) looks.apply_to(scene.particles);
    expand_particles(scene, directory_.path() / "s.json");
    return scene;
  }
  /// Returns the names in the legend of a frame, with the looks of all frames.
  [[nodiscard]] std::vector<std::string> names(std::uint64_t frame) const {
    std::vector<std::string> names;
    const SceneFile scene = at(frame, true);
    for (const LegendEntry& entry : scene.legends.at(0).entries) names.push_back(entry.name);
    return names;
  }
  /// Returns the colour of a particle of a frame.
  [[nodiscard]] Vec3d color(std::uint64_t frame, std::size_t particle, bool fixed = true) const {
    const SceneFile scene = at(frame, fixed);
    return scene.scene.materials[scene.scene.spheres[particle].material].albedo;
  }

 private:
  static std::string frame(const std::string& rows) {
    return "2\nProperties=type:S:1:pos:R:3:q:R:1:p:R:1\n" + rows;
  }
  void write(const std::string& name, const std::string& text) const {
    std::ofstream(directory_.path() / name) << text;
  }
  test::TemporaryDirectory directory_;
};

}  // namespace

TEST_CASE("the range of a colour map is that of all frames") {
  const Trajectory film(R"(, "radius": 1, "color_by": "q")");
  CHECK(film.at(0, false).legends.at(0).high == 2);
  for (std::uint64_t frame = 0; frame < 3; ++frame) {
    const SceneFile scene = film.at(frame, true);
    CHECK(scene.legends.at(0).low == -7);
    CHECK(scene.legends.at(0).high == 5);
    CHECK(scene.particle_files.at(0).facts.notes.empty());  // none is clipped
  }
}

TEST_CASE("equal numbers of one frame do not widen the range of all frames") {
  const Trajectory film(R"(, "radius": 1, "color_by": "z")");  // 0 in all frames
  CHECK(film.at(0, false).legends.at(0).low == -0.5);
  CHECK(film.at(0, true).legends.at(0).low == -0.5);
  const Trajectory first(R"(, "radius": 1, "color_by": "q", "select": "type b or q > 4")");
  CHECK(first.at(0, false).legends.at(0).low == -1.5);  // it has only -1; the others 4 and 5
  CHECK(first.at(0, true).legends.at(0).low == -1);
  CHECK(first.at(0, true).legends.at(0).high == 5);
}

TEST_CASE("a diverging map stays symmetric, and given ends stay") {
  const Trajectory film(R"(, "radius": 1, "color_by": "q", "colormap": "blue-red")");
  CHECK(film.at(1, true).legends.at(0).low == -7);
  CHECK(film.at(1, true).legends.at(0).high == 7);
  const Trajectory given(R"(, "radius": 1, "color_by": "q", "range": "0:3")");
  CHECK(given.at(2, true).legends.at(0).high == 3);
}

TEST_CASE("a name has the same colour whichever other names a frame contains") {
  for (const char* look :
       {R"(, "radius": 1, "material": "by-type")", R"(, "radius": 1, "color_by": "type")"}) {
    const Trajectory film(look);
    CHECK(film.color(0, 0, false) != film.color(1, 1, false));  // b is the first, then the second
    CHECK(film.color(0, 0) == film.color(1, 1));                // b
    CHECK(film.color(0, 1) == film.color(2, 0));                // c
    CHECK(film.color(1, 0) == film.color(2, 1));                // a
    CHECK(film.color(0, 0) != film.color(0, 1));
  }
}

TEST_CASE("a legend names the categories of all frames") {
  for (const char* look :
       {R"(, "radius": 1, "material": "by-type")", R"(, "radius": 1, "color_by": "type")",
        R"(, "radius": 1, "color_by": "q", "color_scale": "categories")"}) {
    const Trajectory film(look);
    CHECK(film.at(0, false).legends.at(0).entries.size() == 2);
    CHECK(film.names(0).size() > 2);
    CHECK(film.names(1) == film.names(0));
    CHECK(film.names(2) == film.names(0));
  }
  CHECK(Trajectory(R"(, "radius": 1, "material": "by-type")").names(0) ==
        std::vector<std::string>{"a", "b", "c"});
}

TEST_CASE("a legend explains the colour of unknown numbers in all frames") {
  for (const char* scale : {"linear", "categories"}) {
    const Trajectory film(
        R"(, "radius": 1, "color_by": "q", "color_scale": ")" + std::string(scale) + "\"", "nan");
    CHECK(film.names(0) == film.names(2));
    const std::string unknown = scale == std::string("linear") ? "not known" : "no name";
    CHECK(std::ranges::count(film.names(0), unknown) == 1);
  }
}

TEST_CASE("arrows have one scale, one width and one legend in all frames") {
  const Trajectory film(R"(, "radius": 0.1, "arrows": "q,p,p")");
  const auto shaft = [&](std::uint64_t frame, bool fixed) {
    const SceneFile scene = film.at(frame, fixed);
    return scene.scene.capsules.at(capsules_of_arrow);  // of the second particle
  };
  const auto length_of = [&](std::uint64_t frame, bool fixed) {
    return length(shaft(frame, fixed).to - shaft(frame, fixed).from);
  };
  CHECK(film.at(0, false).legends.back() != film.at(2, false).legends.back());
  CHECK(film.at(0, true).legends.back() == film.at(2, true).legends.back());
  CHECK(length_of(0, false) == doctest::Approx(length_of(2, false)));  // each is the longest
  CHECK(length_of(0, true) < 0.5 * length_of(2, true));                // 2 of 7
  CHECK(shaft(2, true).radius == shaft(2, false).radius);
}

TEST_CASE("radii by a number have the range of all frames") {
  const Trajectory film(R"(, "radius_by": "q:1:3")");
  const SceneFile scene = film.at(0, true);
  CHECK(scene.scene.spheres[0].radius == doctest::Approx(2));    // -1 of -7 to 5
  CHECK(scene.scene.spheres[1].radius == doctest::Approx(2.5));  // 2
  CHECK(film.at(2, true).scene.spheres[0].radius == doctest::Approx(3));
}

}  // namespace parray
