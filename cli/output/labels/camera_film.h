#pragma once

#include "cli/output/labels/coverage.h"
#include "common/math/vec.h"
#include "common/scene/scene.h"

namespace parray::labels {

/// The projection of points to the picture by a camera without a lens: the inverse of
/// common/trace/integrator/camera_rays.h.
class CameraFilm {
 public:
  /// `camera` is valid; the picture has width x height pixels.
  CameraFilm(const Camera& camera, double width, double height);

  /// Returns a point in the camera's coordinates, in the scene's unit: x to the right, y up, z the
  /// distance from the camera's plane along its viewing direction (as channel "Z").
  [[nodiscard]] Vec3d seen(const Vec3d& point) const;
  /// Returns a direction of the scene in the camera's coordinates.
  [[nodiscard]] Vec3d turned(const Vec3d& direction) const;

  /// Returns the place in the picture of a point from seen(), in pixels from the upper left corner.
  /// A perspective camera needs z > 0.
  [[nodiscard]] Point shown(const Vec3d& seen) const;
  [[nodiscard]] bool perspective() const { return perspective_; }

  /// Returns the pixels per unit of length parallel to the picture: at distance z for a perspective
  /// camera, anywhere for an orthographic one.
  [[nodiscard]] double pixels_per_unit(double z) const;
  /// Returns the distance from the camera to look_at, in the scene's unit.
  [[nodiscard]] double distance() const { return distance_; }

 private:
  Vec3d origin_, right_, up_, forward_;
  double width_, height_;
  double distance_;
  double scale_;  ///< pixels per unit at distance 1, or everywhere
  bool perspective_;
};

}  // namespace parray::labels
