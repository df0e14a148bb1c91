#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string_view>

#include "cli/input/view/principal_axes.h"
#include "common/scene/scene.h"

/// Directions of view of an auto scene.
namespace parray::input {

/// A side of the coordinate axes, with z up, as in OVITO. `front` looks along +y, with x to the
/// right.
enum class View : std::uint8_t { automatic, front, back, left, right, top, bottom, iso };

/// Names of views, in their order.
inline constexpr std::array<std::string_view, 8> view_names{"auto",  "front", "back",   "left",
                                                            "right", "top",   "bottom", "iso"};
/// The same by the axis that points at the viewer.
inline constexpr std::array<std::string_view, 6> view_axes{"+x", "-x", "+y", "-y", "+z", "-z"};

/// Parses one of view_names or view_axes. Throws InputError that names the nearest.
View view_from(std::string_view name);
std::string_view name_of(View view);

/// How the camera looks at spheres.
struct Viewpoint {
  Axes frame;  ///< the picture's axes: right, up, and back to the viewer; around `center`
  /// Unit vector away from the floor or wall of the spheres. It points at least 16 degrees towards
  /// the viewer, so that floor or wall fill the picture.
  Vec3d off_ground;
};

/// Returns the axes of a view that is not `automatic`; `center` is 0.
///
/// - front, back: right +x, -x; up +z. left, right: right -y, +y; up +z.
/// - top, bottom: right +x, -x; up +y.
/// - iso: isometric, x to the right and y to the left of the middle, both away; up +z.
Axes axes_of(View view);

/// Returns the viewpoint for `spheres`, which are not empty. `automatic` means:
/// - Flat groups face the camera: along a coordinate axis or, if they are molecules or askew, a
///   principal axis. A group is flat if its centres reach a tenth as far along one axis as along
///   the next.
/// - Molecules: along their principal axes (principal_axes.h), a little from above and aside.
/// - Others: z up and x to the right, from above and aside.
Viewpoint viewpoint_of(std::span<const Sphere> spheres, View view, bool molecule);

}  // namespace parray::input
