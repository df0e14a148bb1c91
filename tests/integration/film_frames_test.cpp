#include <doctest/doctest.h>

#include <algorithm>
#include <fstream>
#include <string>
#include <vector>

#include "cli/commands/film_folder.h"
#include "cli/commands/frame_scenes.h"
#include "common/base/error.h"
#include "tests/support/contains.h"
#include "tests/support/message_of.h"
#include "tests/support/rooms.h"
#include "tests/support/temporary_directory.h"

namespace parray::test {
namespace {

namespace commands = parray::commands;
using commands::FilmCourse;
using commands::FilmFrames;

/// A trajectory of three frames, a still and a camera path.
class Files {
 public:
  Files() {
    write("run.xyz", "1\n\nC 0 0 0\n2\n\nC 5 0 0\nO 0 9 0\n1\n\nC 0 0 7\n");
    write("still.xyz", "2\n\nC 0 0 0\nO 2 0 0\n");
    write("path.json", R"({"cameras": [
{"frame": 2, "look_from": [0, 0, 90], "look_at": [0, 0, 0], "vfov": 20},
{"frame": 6, "look_from": [90, 0, 0], "look_at": [0, 0, 0], "vfov": 20}]})");
  }
  void write(const std::string& name, const std::string& text) const {
    std::ofstream(path(name)) << text;
  }
  [[nodiscard]] std::string path(const std::string& name) const {
    return (directory_.path() / name).string();
  }

 private:
  TemporaryDirectory directory_;
};

using Numbers = std::vector<std::uint32_t>;

Numbers numbers_of(const FilmCourse& course) {
  return FilmFrames(course, commands::RenderOptions{}).numbers();
}

std::string refusal(const FilmCourse& course) {
  return message_of<InputError>([&] { (void)numbers_of(course); });
}

}  // namespace

TEST_CASE("a film has all frames of a trajectory, or those that are chosen") {
  const Files files;
  FilmCourse course{.scene = files.path("run.xyz")};
  CHECK(numbers_of(course) == Numbers{0, 1, 2});
  course.frames = chosen_frames_from("0:2:2");
  CHECK(numbers_of(course) == Numbers{0, 2});
  course.frames = chosen_frames_from("1:3");
  CHECK(contains(refusal(course), "has 3 frames, 0 to 2"));
  course.frames.reset();
  course.count = 5;
  CHECK(contains(refusal(course), "--count: "));
}

TEST_CASE("a film of one scene needs a camera that moves") {
  const Files files;
  FilmCourse course{.scene = files.path("still.xyz")};
  CHECK(contains(refusal(course), "add --turntable 360 or --camera-path"));
  course.turntable = 360;
  CHECK(numbers_of(course).size() == 100);
  course.count = 7;
  CHECK(numbers_of(course).size() == 7);
  course.camera_path = files.path("path.json");
  CHECK(contains(refusal(course), "--turntable and --camera-path exclude each other"));
  course.turntable = 0;
  CHECK(contains(refusal(course), "frame 0 is outside the path"));
  course.count.reset();
  CHECK(numbers_of(course) == Numbers{2, 3, 4, 5, 6});
  course.frames = chosen_frames_from("2:6:2");
  CHECK(numbers_of(course) == Numbers{2, 4, 6});
}

TEST_CASE("all frames of a trajectory have one camera, which contains all particles") {
  const Files files;
  const FilmCourse course{.scene = files.path("run.xyz")};
  const commands::RenderOptions options;
  FilmFrames film(course, options);
  const SceneFile first = film.scenes().at(0);
  for (const std::uint32_t frame : film.numbers()) {
    const SceneFile scene = film.scenes().at(frame);
    CHECK(scene.scene.camera.look_from == first.scene.camera.look_from);
    CHECK(scene.scene.camera.look_at == first.scene.camera.look_at);
    CHECK(scene.scene.spheres[0].center == first.scene.spheres[0].center);  // the floor
    CHECK(scene.scene.spheres[0].radius == first.scene.spheres[0].radius);
    CHECK(scene.scene.spheres.size() == scene.scenery + (frame == 1 ? 2 : 1));
  }
  // The picture is wide enough for the atoms at (0, 9, 0) and (0, 0, 7).
  CHECK(first.scene.camera.focus_distance > 9 / 0.36);
}

TEST_CASE("numbered files of particles are frames with one camera") {
  const Files files;
  files.write("n-1.xyz", "1\n\nC 0 0 0\n");
  files.write("n-2.xyz", "1\n\nC 30 0 0\n");
  FilmCourse course{.scene = files.path("n-#.xyz")};
  CHECK(contains(refusal(course), "--frames: say which of the numbered files"));
  course.frames = chosen_frames_from("1:2");
  const commands::RenderOptions options;
  FilmFrames film(course, options);
  const SceneFile first = film.scenes().at(1);
  const SceneFile second = film.scenes().at(2);
  CHECK(first.scene.camera.look_from == second.scene.camera.look_from);
  CHECK(second.scene.spheres.back().center.x == 30);
  CHECK(film.files() == std::vector{files.path("n-1.xyz"), files.path("n-2.xyz")});
}

TEST_CASE(
    "a turntable turns the camera and the scenery together, and ends before the first frame") {
  const Files files;
  const FilmCourse course{.scene = files.path("still.xyz"), .count = 4, .turntable = 360};
  const commands::RenderOptions options;
  FilmFrames film(course, options);
  CHECK(commands::angle_at(360, 3, 4) == 270);
  SceneFile still = film.scenes().at(0);
  SceneFile half = film.scenes().at(2);
  film.move_camera(0, still);
  film.move_camera(2, half);
  const TurnAxis axis = film.scenes().axis();
  const auto height = [&](const Vec3d& point) { return dot(point - axis.point, axis.up); };
  const auto aside = [&](const Vec3d& point) {
    return point - axis.point - height(point) * axis.up;
  };
  const Vec3d& from = still.scene.camera.look_from;
  const Vec3d& opposite = half.scene.camera.look_from;
  CHECK(height(from) == doctest::Approx(height(opposite)));
  CHECK(length(aside(from) + aside(opposite)) < 1e-9 * length(from));
  for (std::size_t i = 0; i < still.scenery; ++i) {
    CHECK(length(aside(still.scene.spheres[i].center) + aside(half.scene.spheres[i].center)) <
          1e-9 * length(still.scene.spheres[i].center));
  }
  CHECK(still.scene.spheres.back().center == half.scene.spheres.back().center);
}

TEST_CASE("ffmpeg gets the pictures, their rate and a format that every player reads") {
  const commands::FilmPictures pictures{"/a%b/x.frames", 12, 321, 240, 30};
  const std::vector<std::string> mp4 = commands::encoder_arguments(pictures, "/a%b/x.mp4");
  const auto after = [&](const std::string& name) {
    const auto found = std::ranges::find(mp4, name);
    return found == mp4.end() ? "" : *(found + 1);
  };
  CHECK(after("-framerate") == "30");
  CHECK(after("-i") == "/a%%b/x.frames/frame-%06d.png");
  CHECK(after("-frames:v") == "12");
  CHECK(after("-pix_fmt") == "yuv420p");
  CHECK(contains(after("-vf"), "pad="));
  CHECK(mp4.back() == "/a%b/x.mp4");
  CHECK(commands::needs_padding(pictures, "x.webm"));
  CHECK_FALSE(commands::needs_padding(pictures, "x.gif"));
  CHECK_FALSE(commands::needs_padding({"x", 12, 320, 240, 30}, "x.mp4"));
  CHECK(message_of<InputError>([] {
          commands::check_film_name("x.avi");
        }).find("use a name that ends in .mp4, .webm or .gif") != std::string::npos);
}

}  // namespace parray::test
