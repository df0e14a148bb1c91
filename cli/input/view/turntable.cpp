#include "cli/input/view/turntable.h"

#include <cmath>
#include <numbers>

namespace parray::input {
namespace {

/// Turns a vector about the direction of the axis.
Vec3d turned_direction(const Vec3d& v, const Vec3d& up, double degrees) {
  const double angle = degrees / 180 * std::numbers::pi;
  const double cosine = std::cos(angle);
  return cosine * v + std::sin(angle) * cross(up, v) + ((1 - cosine) * dot(up, v)) * up;
}

}  // namespace

Vec3d turned(const Vec3d& point, const TurnAxis& axis, double degrees) {
  if (std::fmod(degrees, 360) == 0) return point;
  return axis.point + turned_direction(point - axis.point, axis.up, degrees);
}

Camera turned(const Camera& camera, const TurnAxis& axis, double degrees) {
  if (std::fmod(degrees, 360) == 0) return camera;
  Camera out = camera;
  out.look_from = turned(camera.look_from, axis, degrees);
  out.look_at = turned(camera.look_at, axis, degrees);
  out.up = turned_direction(camera.up, axis.up, degrees);
  return out;
}

TurnAxis axis_of(const Camera& camera) { return {camera.look_at, normalize(camera.up)}; }

}  // namespace parray::input
