#include "cli/output/labels/camera_film.h"

namespace parray::labels {

CameraFilm::CameraFilm(const Camera& camera, double width, double height)
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

Vec3d CameraFilm::turned(const Vec3d& direction) const {
  return {dot(direction, right_), dot(direction, up_), dot(direction, forward_)};
}

Vec3d CameraFilm::seen(const Vec3d& point) const { return turned(point - origin_); }

double CameraFilm::pixels_per_unit(double z) const { return perspective_ ? scale_ / z : scale_; }

Point CameraFilm::shown(const Vec3d& seen) const {
  const double scale = pixels_per_unit(seen.z);
  return {width_ / 2 + scale * seen.x, height_ / 2 - scale * seen.y};
}

}  // namespace parray::labels
