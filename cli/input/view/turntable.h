#pragma once

#include "common/scene/scene.h"

/// Turns the camera around the scene, as if the scene stood on a turntable.
namespace parray::input {

/// The axis of a turntable.
struct TurnAxis {
  Vec3d point;        ///< on the axis
  Vec3d up{0, 0, 1};  ///< unit vector along the axis
};

/// Returns `point` after a turn about the axis by an angle in degrees. Seen from above, positive
/// angles turn counter-clockwise. Multiples of 360 degrees change nothing. Source: Rodrigues'
/// formula.
Vec3d turned(const Vec3d& point, const TurnAxis& axis, double degrees);

/// Returns the camera after the same turn of its place, its target and its upward direction.
Camera turned(const Camera& camera, const TurnAxis& axis, double degrees);

/// Returns the axis through the target of a camera along its upward direction.
TurnAxis axis_of(const Camera& camera);

}  // namespace parray::input
