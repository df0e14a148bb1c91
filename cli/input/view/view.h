#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

#include "common/scene/limits.h"
#include "common/scene/scene.h"

/// Directions of view of an automatic scene, and turntables: the camera turns around the scene, as
/// if the scene stood on one.
namespace parray::input {

/// A right-handed frame: right x up = back.
struct Axes {
  Vec3d right, up, back;  ///< orthogonal unit vectors
  Vec3d center;
};

/// Returns the frame around the mean of the spheres' centres in which they spread most along
/// `right` and least along `back`. `spheres` is not empty.
///
/// Computes the eigenvectors of the covariance matrix by cyclic Jacobi rotations (Golub and Van
/// Loan, Matrix Computations, 8.5). It uses only + - * / sqrt, so all machines agree. Scaling all
/// centres by a power of two scales `center` and changes nothing else. If spreads are nearly equal
/// and `leaning` is true, the frame prefers the coordinate axes: x right, y up, z back. The largest
/// component of `up` and of `back` is positive.
Axes principal_axes(std::span<const Sphere> spheres, bool leaning = true);

/// Returns a radius for centres without radii. It is half the spacing of a cubic lattice in a box,
/// a sheet or a line with the same number of points and the same spread, at least
/// limits::min_radius. Returns 1 if all centres are equal. Rotating the centres changes the radius
/// only by rounding. Scaling the centres scales it. `spheres` is not empty.
double lattice_radius(std::span<const Sphere> spheres);

/// A direction of view is a side of the coordinate axes, with z up, as in OVITO. `front` looks
/// along +y, with x to the right.
enum class View : std::uint8_t { automatic, front, back, left, right, top, bottom, iso };

/// Names of the views, in the order of View.
inline constexpr std::array<std::string_view, 8> view_names{"auto",  "front", "back",   "left",
                                                            "right", "top",   "bottom", "iso"};
/// Other names of the six sides: the axis that points to the viewer. In this order they name the
/// views right, left, back, front, top and bottom.
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

/// Returns the axes of a view other than `automatic`. `center` is 0. The list says which directions
/// of the scene point to the right and up in the picture.
///
/// - front, back: right +x, -x; up +z. left, right: right -y, +y; up +z.
/// - top, bottom: right +x, -x; up +y.
/// - iso: the viewer is at (4, -6, 3), and (3, 2, 0) points to the right; z points up. x comes
///   towards the viewer, and y goes away. The exact isometric direction would let the near corner
///   of a cube hide the far corner. This direction lets no corner or edge hide another.
Axes axes_of(View view);

/// How the user turns a view. Angles are in degrees.
struct Turning {
  std::optional<Vec3d> up{};  ///< direction of the scene that replaces z in all views; not zero
  /// Angle by which the camera moves to the right, on a circle around the upward direction. In
  /// azimuth_range.
  std::optional<double> azimuth{};
  std::optional<double> elevation{};  ///< angle by which the camera rises, in elevation_range

  [[nodiscard]] bool empty() const { return !up && !azimuth && !elevation; }
};
inline constexpr NumberRange azimuth_range{-360, 360};
inline constexpr NumberRange elevation_range{-90, 90};

/// Parses "x", "-y", "+z" or three numbers "0,1,1", and scales the largest component to 1 or -1.
/// Throws InputError for other texts and for 0,0,0.
Vec3d up_from(std::string_view text);

/// Returns the viewpoint for `spheres`, which are not empty. `molecule` matters only for the view
/// `automatic`, which chooses as follows:
/// - Flat groups face the camera, along a coordinate axis. Flat molecules and oblique groups face
///   it along a principal axis. A group is flat if its smallest extent is at most a tenth of the
///   middle one. A rod is not flat: its middle extent is at most a tenth of the largest.
/// - Other molecules: along their principal axes (principal_axes()), slightly from above and from
///   the side.
/// - All others: z up and x to the right, from above and from the side.
///
/// `turning` changes this view:
/// - With `up`, every view is the view of a scene in which z was turned to `up`, with x as far to
///   the right as possible. If `up` is x or -x, y takes its place. The automatic view then treats
///   all particles as the last kind of the list.
/// - `azimuth` and `elevation` replace the angles of the automatic view. Other views turn by these
///   angles. For top and bottom, the picture's vertical direction is the axis of the azimuth.
///
/// Throws InputError if the elevation would turn the camera over the top.
Viewpoint viewpoint_of(std::span<const Sphere> spheres, View view, bool molecule,
                       const Turning& turning = {});

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
