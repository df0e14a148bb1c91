// The shapes of all frames of a film: in the picture, and of the same sizes.
#include <doctest/doctest.h>

#include <fstream>
#include <string>
#include <utility>
#include <vector>

#include "cli/commands/frame_scenes.h"
#include "common/process/command_line.h"
#include "tests/support/rooms.h"
#include "tests/support/sphere_groups.h"
#include "tests/support/temporary_directory.h"

namespace parray::test {
namespace {

namespace commands = parray::commands;

/// The scenes of a film of a file, or of numbered files #, with options of the command line.
class Scenes {
 public:
  Scenes(const std::string& name, const std::vector<std::string>& texts, const std::string& words) {
    commands::FilmCourse course{.scene = (directory_.path() / name).string()};
    for (std::size_t i = 0; i < texts.size(); ++i) {
      std::string file = course.scene;
      const std::size_t at = file.find('#');
      if (at != std::string::npos) file.replace(at, 1, std::to_string(i));
      std::ofstream(file) << texts[i];
    }
    if (texts.size() > 1) {
      course.frames = chosen_frames_from("0:" + std::to_string(texts.size() - 1));
    }
    process::CommandLine line;
    commands::RenderOptions options;
    options.add_to(line);
    line.parse(words);
    commands::FilmFrames film(course, options, [this](std::size_t read, std::size_t all) {
      CHECK(read <= all);
      ++read_;
    });
    for (const std::uint32_t frame : film.numbers()) scenes_.push_back(film.scenes().at(frame));
  }

  [[nodiscard]] const SceneFile& operator[](std::size_t frame) const { return scenes_.at(frame); }
  [[nodiscard]] std::size_t size() const { return scenes_.size(); }
  [[nodiscard]] int read() const { return read_; }  ///< frames read to make them alike

 private:
  TemporaryDirectory directory_;
  std::vector<SceneFile> scenes_;
  int read_ = 0;
};

/// Returns the spheres of particles and the ends of capsules.
std::vector<Sphere> ends_in(const SceneFile& file) {
  std::vector<Sphere> ends(file.scene.spheres.begin() + file.scenery, file.scene.spheres.end());
  for (const Capsule& capsule : file.scene.capsules) {
    ends.push_back({capsule.from, capsule.radius, 0});
    ends.push_back({capsule.to, capsule.radius, 0});
  }
  return ends;
}

void check_all_inside(const Scenes& film) {
  for (std::size_t frame = 0; frame < film.size(); ++frame) {
    CAPTURE(frame);
    const SceneFile& file = film[frame];
    const Film picture(file.scene.camera, 4.0 / 3);
    CHECK(file.scene.camera.look_from == film[0].scene.camera.look_from);
    for (const Sphere& end : ends_in(file)) {
      for (const auto& [x, y] : {std::pair{1, 0}, {-1, 0}, {0, 1}, {0, -1}}) {
        CHECK(picture.inside(end, x, y) > 1);
      }
    }
  }
}

/// Two atoms in a cell that share a bond in its middle, or across its faces.
const std::string across =
    "2\nLattice=\"4 0 0 0 4 0 0 0 4\"\nC 1.4 2 2\nC 2.6 2 2\n"
    "2\nLattice=\"4 0 0 0 4 0 0 0 4\"\nC 0.6 2 2\nC 3.4 2 2\n";

/// Two frames in which one particle has this velocity.
std::string with_velocities(const std::string& first, const std::string& second) {
  const std::string head = "3\nProperties=type:S:1:pos:R:3:velo:R:3\n";
  const std::string rest = "a 2 0 0 0 0 0\na 4 0 0 0 0 0\n";
  return head + "a 0 0 0 " + first + "\n" + rest + head + "a 0 0 0 " + second + "\n" + rest;
}

/// A data file of LAMMPS without masses, so without elements. Its three particles, in a row, have
/// this distance and two bonds.
std::string bonded(double distance) {
  const std::string x = std::to_string(1 + distance);
  return "title\n\n3 atoms\n2 bonds\n1 bond types\n1 atom types\n0 99 xlo xhi\n0 99 ylo yhi\n"
         "0 99 zlo zhi\n\nAtoms # bond\n\n1 1 1 1 1 1\n2 1 1 " +
         x + " 1 1\n3 1 1 " + x + " " + x + " 1\n\nBonds\n\n1 1 1 2\n2 1 2 3\n";
}

}  // namespace

TEST_CASE("the picture of a film contains the sticks of all frames") {
  const Scenes film("a.xyz", {across}, "--style sticks --crystal off");
  CHECK(film[1].scene.capsules.size() == 2);
  check_all_inside(film);
  CHECK(film.read() == 2);  // each frame once: elements give the sticks their radius
}

TEST_CASE("the picture of a film contains the arrows of all frames, at the scale of the film") {
  const Scenes film("a.xyz", {with_velocities("0 0.1 0", "0 40 0")}, "--arrows velocity");
  check_all_inside(film);
  CHECK(film[0].legends == film[1].legends);
  CHECK(film[1].scene.capsules[0].to.y > 2);
  CHECK(film[0].scene.capsules[0].to.y < 0.1);
  CHECK(film.read() == 4);
}

TEST_CASE("the picture of a film contains the solid cell of all frames") {
  std::string text = across;
  text.replace(text.rfind("4 0 0 0 4 0 0 0 4"), 17, "9 0 0 0 9 0 0 0 9");
  const Scenes film("a.xyz", {text}, "--solid-cell --crystal off");
  CHECK(film[0].scene.capsules.size() >= 12);
  check_all_inside(film);
}

TEST_CASE("the picture of a film contains radii by a number, whose range is that of all frames") {
  const std::string head = "2\nProperties=type:S:1:pos:R:3:q:R:1\n";
  const std::string text = head + "a 3 0 0 -900\na 4 0 0 -899\n" + head + "a 0 0 0 1\na 9 0 0 2\n";
  const Scenes film("a.xyz", {text}, "--radius-by q:0.1:3");
  CHECK(ends_in(film[1])[0].radius > 2.9);  // alone, the frame would give it 0.1
  check_all_inside(film);
}

TEST_CASE("distant particles fade alike in all frames of a film") {
  const std::string near = "2\n\nC 0 0 0\nC 3 0 0\n";
  const Scenes film("a.xyz", {near + "2\n\nC 0 0 0\nC 0 9 0\n"}, "--style night --view front");
  const NumberBounds depths = film[0].postprocessing.depths;
  CHECK(depths == film[1].postprocessing.depths);
  CHECK(depths.high - depths.low == doctest::Approx(9 + 1.7).epsilon(0.01));
}

TEST_CASE("sticks without elements have the radius of the first frame in all frames") {
  for (const std::string style : {"sticks", "balls-and-sticks"}) {
    CAPTURE(style);
    const Scenes film("n-#.data", {bonded(1), bonded(8), bonded(0.5)}, "--style " + style);
    for (std::size_t frame = 0; frame < film.size(); ++frame) {
      CHECK(film[frame].scene.capsules.size() == 4);
      CHECK(film[frame].scene.capsules[0].radius == doctest::Approx(0.1));
      CHECK(ends_in(film[frame])[0].radius == ends_in(film[0])[0].radius);
    }
    check_all_inside(film);
  }
}

}  // namespace parray::test
