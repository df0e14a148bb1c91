#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string_view>

#include "cli/input/view/principal_axes.h"
#include "common/scene/scene.h"

/// Directions of view of an automatic scene.
namespace parray::input {

/// A direction of view is a side of the coordinate axes, with z up, as in OVITO. `front` looks
/// along +y, with x to the right.
enum class View : std::uint8_t { automatic, front, back, left, right, top, bottom, iso };

/// Names of the views, in the order of View.
inline constexpr std::array<std::string_view, 8> view_names{"auto",  "front", "back",   "left",
                                                            "right", "top",   "bottom", "iso"};
/// Names of the first six views by the axis that points to the viewer.
inline constexpr std::array<std::string_view, 6> view_axes{"+x", "-x", "+y", "-y", "+z", "-z"};

/// Parses one of view_names or view_axes. Throws InputError, which suggests the nearest name.
View view_from(std::string_view name);
std::string_view name_of(View view);

/// A direction from which the camera looks at spheres.
struct Viewpoint {
  Axes frame;  ///< axes of the picture around `center`: right, up, and back to the viewer
  /// Unit vector that points away from the floor or wall. It points at least 16 degrees towards the
  /// viewer, so that the floor or wall fills the picture.
  Vec3d off_ground;
};

/// Returns the axes of a view other than `automatic`. `center` is 0.
///
/// - front, back: right +x, -x; up +z. left, right: right -y, +y; up +z.
/// - top, bottom: right +x, -x; up +y.
/// - iso: isometric, x to the right and y to the left of the middle, both away; up +z.
Axes axes_of(View view);

/// Returns the viewpoint for `spheres`, which are not empty. `automatic` chooses as follows:
/// - Flat groups face the camera, along a coordinate axis. Flat molecules and oblique groups face
///   it along a principal axis. A group is flat if its centres extend a tenth as far along one axis
///   as along the next.
/// - Other molecules: along their principal axes (principal_axes.h), slightly from above and from
///   the side.
/// - All others: z up and x to the right, from above and from the side.
Viewpoint viewpoint_of(std::span<const Sphere> spheres, View view, bool molecule);

}  // namespace parray::input
