#pragma once

#include "cli/output/labels/canvas.h"
#include "common/math/vec.h"
#include "common/scene/scene.h"

namespace parray::labels {

/// The projection of points to the picture by a camera without a lens: the inverse of
/// common/trace/integrator/camera_rays.h.
class CameraFilm {
 public:
  /// `camera` is valid; the picture has width x height pixels.
  CameraFilm(const Camera& camera, double width, double height)
      : origin_(camera.look_from),
        forward_(normalize(camera.look_at - camera.look_from)),
        width_(width),
        height_(height),
        distance_(length(camera.look_at - camera.look_from)),
        scale_(height / (camera.projection == Projection::perspective ? 2 * camera.tan_half_vfov
                                                                      : camera.view_height)),
        perspective_(camera.projection == Projection::perspective) {
    right_ = normalize(cross(forward_, normalize(camera.up)));
    up_ = cross(right_, forward_);
  }

  /// Returns a point in the camera's coordinates, in the scene's unit: x to the right, y up, z the
  /// distance from the camera's plane along its viewing direction (as channel "Z").
  [[nodiscard]] Vec3d seen(const Vec3d& point) const { return turned(point - origin_); }
  /// Returns a direction of the scene in the camera's coordinates.
  [[nodiscard]] Vec3d turned(const Vec3d& direction) const {
    return {dot(direction, right_), dot(direction, up_), dot(direction, forward_)};
  }

  /// Returns the place in the picture of a point from seen(), in pixels from the upper left corner.
  /// A perspective camera needs z > 0.
  [[nodiscard]] Point shown(const Vec3d& seen) const {
    const double scale = pixels_per_unit(seen.z);
    return {width_ / 2 + scale * seen.x, height_ / 2 - scale * seen.y};
  }
  [[nodiscard]] bool perspective() const { return perspective_; }

  /// Returns the pixels per unit of length parallel to the picture: at distance z for a perspective
  /// camera, anywhere for an orthographic one.
  [[nodiscard]] double pixels_per_unit(double z) const {
    return perspective_ ? scale_ / z : scale_;
  }
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
