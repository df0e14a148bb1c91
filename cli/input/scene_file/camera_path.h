#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "common/scene/scene.h"

namespace parray::input {

/// Where a camera is at which frame: at a key as it is written there, between two keys along a
/// curve through all of them.
///
/// look_from and look_at follow a Catmull-Rom spline for keys at any distance (the tangent at a key
/// is the difference of its neighbours over their distance in frames, one-sided at the ends); vfov
/// or view_height, aperture and focus_distance are interpolated linearly, which cannot leave their
/// ranges; up likewise, then normalised. Where neither of two keys has a focus_distance, look_at is
/// in focus. All have the same projection.
class CameraPath {
 public:
  /// Reads { "cameras": [ { "frame": N, and what a scene's camera has }, ... ] }, the frames
  /// ascending. Throws InputError "FILE:LINE: /json/pointer: problem: remedy".
  explicit CameraPath(const std::filesystem::path& file);

  /// Throws InputError outside of the keys, and where the curve leads to a camera that sees
  /// nothing.
  [[nodiscard]] Camera at(std::uint64_t frame) const;

  struct Key {
    std::uint64_t frame = 0;
    Camera camera;
    bool focuses = false;  ///< has a focus_distance
  };

 private:
  [[nodiscard]] Camera between(std::size_t key, std::uint64_t frame) const;
  [[nodiscard]] Vec3d point(std::size_t key, double share, Vec3d Camera::*member) const;
  [[nodiscard]] Vec3d tangent(std::size_t key, Vec3d Camera::*member) const;

  std::string name_;
  std::vector<Key> keys_;
};

}  // namespace parray::input
