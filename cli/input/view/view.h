#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string_view>

#include "cli/input/view/principal_axes.h"
#include "common/scene/scene.h"

/// From where a portrait is taken.
namespace parray::input {

/// A side of the coordinate axes, z up, as OVITO names them. `front` looks along +y, with x to the
/// right.
enum class View : std::uint8_t { automatic, front, back, left, right, top, bottom, iso };

/// Names of views, in their order.
inline constexpr std::array<std::string_view, 8> view_names{"auto",  "front", "back",   "left",
                                                            "right", "top",   "bottom", "iso"};
/// The same by the axis that points at the viewer.
inline constexpr std::array<std::string_view, 6> view_axes{"+x", "-x", "+y", "-y", "+z", "-z"};

/// One of view_names or view_axes. Throws InputError that names the nearest.
View view_from(std::string_view name);
std::string_view name_of(View view);

/// How spheres are looked at.
struct Viewpoint {
  Axes frame;  ///< the picture's axes: right, up, and back to the viewer; around `center`
  /// Unit vector away from what the spheres stand on, or hang before. At least 16 degrees towards
  /// the viewer, so that it fills the picture.
  Vec3d off_ground;
};

/// The axes of a view that is not `automatic`; `center` is 0.
///
/// - front, back: right +x, -x; up +z. left, right: right -y, +y; up +z.
/// - top, bottom: right +x, -x; up +y.
/// - iso: isometric, x to the right and y to the left of the middle, both away; up +z.
Axes axes_of(View view);

/// `spheres` is not empty. What `automatic` is:
/// - Flat groups, whose centres reach a tenth as far along one axis as along the next, are seen
///   face on: along a coordinate axis or, if they are molecules or askew, a principal one.
/// - Molecules along their principal axes (principal_axes.h), a little from above and aside.
/// - Others with z up and x to the right, from above and aside.
Viewpoint viewpoint_of(std::span<const Sphere> spheres, View view, bool molecule);

}  // namespace parray::input
