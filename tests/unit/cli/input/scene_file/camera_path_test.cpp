#include "cli/input/scene_file/camera_path.h"

#include <doctest/doctest.h>

#include <fstream>
#include <string>

#include "common/base/error.h"
#include "tests/support/contains.h"
#include "tests/support/message_of.h"
#include "tests/support/rooms.h"
#include "tests/support/temporary_directory.h"

namespace parray::test {
namespace {

/// A path that is written to a file and read again.
class PathFile {
 public:
  explicit PathFile(const std::string& cameras) : file_(directory_.path() / "path.json") {
    std::ofstream(file_) << "{\"cameras\": [" << cameras << "]}";
  }
  [[nodiscard]] CameraPath read() const { return CameraPath(file_); }
  [[nodiscard]] std::string message() const {
    return message_of<InputError>([&] { (void)read(); });
  }
  [[nodiscard]] std::string message_at(std::uint64_t frame) const {
    return message_of<InputError>([&] { (void)read().at(frame); });
  }

 private:
  TemporaryDirectory directory_;
  std::filesystem::path file_;
};

std::string key(int frame, const std::string& from, const std::string& more = {}) {
  return "{\"frame\": " + std::to_string(frame) + ", \"look_from\": " + from +
         ", \"look_at\": [0, 0, 0], \"vfov\": 30" + more + "}";
}

}  // namespace

TEST_CASE("at a key the camera is that of the file, between keys it moves evenly") {
  const CameraPath path =
      PathFile(key(0, "[8, 0, 1]", R"(, "up": [0, 0, 2])") + "," + key(4, "[0, 8, 1]")).read();
  CHECK(path.at(0).look_from == Vec3d{8, 0, 1});
  CHECK(path.at(0).up == Vec3d{0, 0, 2});
  CHECK(path.at(4).look_from == Vec3d{0, 8, 1});
  CHECK(path.at(1).look_from == Vec3d{6, 2, 1});
  CHECK(path.at(2).look_from == Vec3d{4, 4, 1});
  CHECK(path.at(2).vfov == 30);
  CHECK(length(path.at(1).up) == doctest::Approx(1));
  CHECK(path.at(2).up.y == path.at(2).up.z);
}

TEST_CASE("a path with two lists of cameras is refused") {
  const std::string message =
      PathFile(key(0, "[8, 0, 1]") + "], \"cameras\": [" + key(4, "[0, 8, 1]")).message();
  CHECK(contains(message, "path.json:1: /cameras: duplicate key 'cameras': remove one of them"));
}

TEST_CASE("the curve through three keys has no corner at the middle one") {
  const CameraPath path =
      PathFile(key(0, "[0, 0, 9]") + "," + key(10, "[1, 0, 9]") + "," + key(30, "[5, 0, 9]"))
          .read();
  const auto x = [&](std::uint64_t frame) { return path.at(frame).look_from.x; };
  CHECK(x(10) == 1);
  const double speed_before = x(10) - x(9);
  const double speed_after = x(11) - x(10);
  CHECK(speed_before == doctest::Approx(5.0 / 30).epsilon(0.1));
  CHECK(speed_after == doctest::Approx(5.0 / 30).epsilon(0.1));
}

TEST_CASE("look_at stays in focus unless a key gives the focus") {
  const std::string first = key(0, "[0, 0, 10]", R"(, "aperture": 1)");
  CHECK(PathFile(first + "," + key(2, "[0, 0, 20]", R"(, "aperture": 2)"))
            .read()
            .at(1)
            .focus_distance == 15);
  const Camera focused =
      PathFile(first + "," + key(2, "[0, 0, 20]", R"(, "focus_distance": 30)")).read().at(1);
  CHECK(focused.focus_distance == 20);
  CHECK(focused.aperture == 0.5);
}

TEST_CASE("an invalid camera path is refused in one line") {
  CHECK(contains(PathFile("").message(), "missing key 'cameras'"));
  CHECK(contains(PathFile(key(3, "[1, 0, 0]") + "," + key(3, "[2, 0, 0]")).message(),
                 "/cameras/1/frame: frame 3 is not after"));
  CHECK(contains(PathFile(R"({"look_from": [1, 0, 0]})").message(), "missing key 'frame'"));
  CHECK(contains(PathFile(key(0, "[0, 0, 0]")).message(), "the same point"));
  CHECK(
      contains(PathFile(key(0, "[1, 0, 0]", R"(, "speed": 1)")).message(), "unknown key 'speed'"));
  const PathFile through(key(0, "[1, 0, 0]") + "," + key(2, "[-1, 0, 0]"));
  CHECK(contains(through.message_at(1), "at frame 1, between two cameras, look_from"));
  CHECK(contains(through.message_at(3), "frame 3 is outside the path"));
  CHECK(contains(message_of<InputError>([] { CameraPath("/nowhere.json"); }), "cannot be read"));
}

TEST_CASE("an orthographic camera's view grows evenly, and never becomes another projection") {
  const auto parallel = [](int frame, const std::string& height) {
    return "{\"frame\": " + std::to_string(frame) + R"(, "look_from": [0, 0, 9],
      "look_at": [0, 0, 0], "projection": "orthographic", "view_height": )" +
           height + "}";
  };
  const CameraPath path = PathFile(parallel(0, "2") + "," + parallel(4, "6")).read();
  CHECK(path.at(1).projection == Projection::orthographic);
  CHECK(path.at(0).view_height == 2);
  CHECK(path.at(1).view_height == 3);
  CHECK(path.at(4).view_height == 6);
  CHECK(path.at(1).vfov == 0);
  CHECK(path.at(1).tan_half_vfov == 0);
  CHECK(contains(PathFile(key(0, "[0, 0, 9]") + "," + parallel(4, "6")).message(),
                 "/cameras/1: the projection differs from that of the previous camera"));
}

}  // namespace parray::test
