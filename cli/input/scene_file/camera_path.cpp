#include "cli/input/scene_file/camera_path.h"

#include <algorithm>
#include <array>
#include <fstream>
#include <string_view>
#include <utility>

#include "cli/input/scene_file/json_stream.h"
#include "cli/input/scene_file/json_value.h"
#include "cli/input/scene_file/scene_sections.h"
#include "common/base/error.h"
#include "common/base/printable.h"
#include "common/scene/limits.h"

namespace parray::input {
namespace {

constexpr std::array<std::string_view, 1> sections{"cameras"};

class KeySink final : public JsonSink {
 public:
  explicit KeySink(const std::string& file) : root_(file) {}

  JsonDelivery on_key(const std::string& key, std::uint64_t line) override {
    if (key != sections[0]) fail_unknown_key(key, line, root_, sections);
    if (began_) root_.at(key).fail(line, "duplicate key '" + key + "': remove one of them");
    began_ = true;
    return JsonDelivery::by_item;
  }
  void on_member(const JsonMember& /*member*/) override {}
  void on_child(const JsonMember& child) override {
    static const auto known = [] {
      std::vector<std::string_view> keys(camera_keys().begin(), camera_keys().end());
      keys.insert(keys.begin(), "frame");
      return keys;
    }();
    const JsonPlace section = root_.at("cameras");
    const JsonPlace place = section.at(keys_.size());
    const JsonFields fields(child.value, place, known);
    fields.any("frame", "the number of the frame of this camera");
    CameraPath::Key key{fields.integer("frame", {0, limits::max_frame}), camera_from(fields),
                        fields.find("focus_distance") != nullptr};
    if (!keys_.empty() && key.frame <= keys_.back().frame) {
      place.at("frame").fail(fields.line(), "frame " + std::to_string(key.frame) +
                                                " is not after the previous camera's frame: "
                                                "write cameras in the order of their frames");
    }
    if (!keys_.empty() && key.camera.projection != keys_.back().camera.projection) {
      place.fail(fields.line(),
                 "the projection differs from that of the previous camera: "
                 "use one projection, or write two paths");
    }
    if (keys_.size() == limits::max_frames) {
      place.fail(fields.line(), "the path has more than " + std::to_string(limits::max_frames) +
                                    " cameras: remove some");
    }
    keys_.push_back(key);
  }

  std::vector<CameraPath::Key> finish(std::uint64_t line) {
    if (keys_.empty()) fail_missing_key("cameras", line, root_, "[ ... ] with at least one camera");
    return std::move(keys_);
  }

 private:
  JsonPlace root_;
  bool began_ = false;  // the key "cameras" was read
  std::vector<CameraPath::Key> keys_;
};

double mixed(double a, double b, double share) { return a + share * (b - a); }

double frames_between(const CameraPath::Key& a, const CameraPath::Key& b) {
  return static_cast<double>(b.frame - a.frame);
}

using Keys = std::vector<CameraPath::Key>;

/// Returns the tangent at a key, per frame.
Vec3d tangent(const Keys& keys, std::size_t key, Vec3d Camera::*member) {
  const CameraPath::Key& before = keys[key == 0 ? 0 : key - 1];
  const CameraPath::Key& after = keys[std::min(key + 1, keys.size() - 1)];
  return (1 / frames_between(before, after)) * (after.camera.*member - before.camera.*member);
}

/// Returns a point on the cubic Hermite curve from key `key` to the next key.
Vec3d point(const Keys& keys, std::size_t key, double share, Vec3d Camera::*member) {
  const double s = share;
  const double frames = frames_between(keys[key], keys[key + 1]);
  const double to_next = s * s * (3 - 2 * s);
  return (1 - to_next) * (keys[key].camera.*member) + to_next * (keys[key + 1].camera.*member) +
         (frames * s * (1 - s) * (1 - s)) * tangent(keys, key, member) +
         (frames * s * s * (s - 1)) * tangent(keys, key + 1, member);
}

/// Returns the camera at a frame after key `key` and before the next key.
Camera between(const Keys& keys, std::size_t key, std::uint64_t frame) {
  const CameraPath::Key& a = keys[key];
  const CameraPath::Key& b = keys[key + 1];
  const double share = static_cast<double>(frame - a.frame) / frames_between(a, b);
  Camera camera;
  camera.look_from = point(keys, key, share, &Camera::look_from);
  camera.look_at = point(keys, key, share, &Camera::look_at);
  const Vec3d up = (1 - share) * normalize(a.camera.up) + share * normalize(b.camera.up);
  camera.up = length(up) > 0 ? normalize(up) : up;
  camera.projection = a.camera.projection;
  camera.vfov = mixed(a.camera.vfov, b.camera.vfov, share);
  camera.tan_half_vfov = tan_half_of(camera.vfov);
  camera.view_height = mixed(a.camera.view_height, b.camera.view_height, share);
  camera.aperture = mixed(a.camera.aperture, b.camera.aperture, share);
  camera.focus_distance = a.focuses || b.focuses
                              ? mixed(a.camera.focus_distance, b.camera.focus_distance, share)
                              : length(camera.look_at - camera.look_from);
  return camera;
}

}  // namespace

CameraPath::CameraPath(const std::filesystem::path& file) : name_(file.string()) {
  std::ifstream input(file, std::ios::binary);
  if (!input || std::filesystem::is_directory(file)) {
    throw InputError(printable(name_, 4096) + ": cannot be read: check the path");
  }
  KeySink sink(name_);
  const std::uint64_t line = parse_json(input, name_, sink);
  keys_ = sink.finish(line);
}

Camera CameraPath::at(std::uint64_t frame) const {
  if (frame < keys_.front().frame || frame > keys_.back().frame) {
    throw InputError(printable(name_, 4096) + ": frame " + std::to_string(frame) +
                     " is outside the path, which goes from frame " +
                     std::to_string(keys_.front().frame) + " to " +
                     std::to_string(keys_.back().frame));
  }
  const auto next = std::ranges::lower_bound(keys_, frame, {}, &Key::frame);
  if (next->frame == frame) return next->camera;
  const Camera camera = between(keys_, static_cast<std::size_t>(next - keys_.begin()) - 1, frame);
  const std::string problem = problem_with(camera);
  if (!problem.empty()) {
    throw InputError(printable(name_, 4096) + ": at frame " + std::to_string(frame) +
                     ", between two cameras, " + problem);
  }
  return camera;
}

}  // namespace parray::input
