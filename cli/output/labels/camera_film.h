#pragma once

#include <optional>

#include "cli/output/labels/coverage.h"
#include "common/math/vec.h"
#include "common/scene/scene.h"

namespace parray::labels {

/// Where a camera, its lens left aside, shows points of the scene: the inverse of
/// common/trace/integrator/camera_rays.h.
class CameraFilm {
 public:
  /// `camera` has passed the reader's checks; the picture is width x height pixels.
  CameraFilm(const Camera& camera, double width, double height);

  /// A point as the camera has it: x to the right, y up, z the distance from its plane along the
  /// direction in which it looks (that of channel "Z"), in the scene's unit.
  [[nodiscard]] Vec3d seen(const Vec3d& point) const;
  /// A direction of the scene as the camera has it.
  [[nodiscard]] Vec3d turned(const Vec3d& direction) const;

  /// Where a point is shown that seen() gave, in pixels from the picture's upper left corner. With
  /// perspective z > 0 is needed.
  [[nodiscard]] Point shown(const Vec3d& seen) const;
  [[nodiscard]] bool perspective() const { return perspective_; }

  /// Pixels that a unit of length takes, parallel to the picture: at that distance with
  /// perspective, anywhere without.
  [[nodiscard]] double pixels_per_unit(double z) const;
  /// Of look_at.
  [[nodiscard]] double distance() const { return distance_; }

 private:
  Vec3d origin_, right_, up_, forward_;
  double width_, height_;
  double distance_;
  double scale_;  ///< pixels a unit at distance 1, or everywhere
  bool perspective_;
};

}  // namespace parray::labels
