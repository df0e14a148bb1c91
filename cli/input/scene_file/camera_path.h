#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "common/scene/scene.h"

namespace parray::input {

/// A moving camera: the camera of each frame of a film or series. A file contains the cameras of
/// some frames, the keys. The cameras of the frames between two keys follow a curve through the
/// keys.
///
/// look_from and look_at follow a Catmull-Rom spline for keys at any distance. The tangent at a key
/// is the difference of the keys before and after it, divided by their distance in frames. At the
/// first and the last key, the key itself replaces the missing neighbour. vfov or view_height,
/// aperture and focus_distance are interpolated linearly, so they stay in their ranges. up is
/// interpolated linearly and normalised. The focus_distance of a key without one is the distance to
/// its look_at. Between two such keys, the interpolated look_at is in focus. All keys have the same
/// projection.
class CameraPath {
 public:
  /// Reads { "cameras": [ { "frame": N, and the keys of a scene's camera }, ... ] } with ascending
  /// frames and at least one camera. Throws InputError "FILE:LINE: /json/pointer: problem: remedy".
  /// LINE and pointer are missing if the file cannot be read.
  explicit CameraPath(const std::filesystem::path& file);

  /// Returns the camera at a frame. Throws InputError outside the path, and if the interpolated
  /// camera is not valid.
  [[nodiscard]] Camera at(std::uint64_t frame) const;

  /// Return the numbers of the first and of the last frame.
  [[nodiscard]] std::uint32_t first() const {
    return static_cast<std::uint32_t>(keys_.front().frame);
  }
  [[nodiscard]] std::uint32_t last() const {
    return static_cast<std::uint32_t>(keys_.back().frame);
  }

  struct Key {
    std::uint64_t frame = 0;
    Camera camera;
    bool focuses = false;  ///< true: the file gives focus_distance
  };

 private:
  std::string name_;
  std::vector<Key> keys_;
};

}  // namespace parray::input
