#include "cli/input/view/view.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "cli/input/color/number_bounds.h"
#include "common/base/error.h"
#include "common/base/printable.h"
#include "common/base/suggest.h"
#include "common/base/text.h"
#include "common/scene/limits.h"

namespace parray::input {
namespace {

/// Largest ratio of the third extent to the second for a flat group.
constexpr double flatness = 0.1;
/// Least sine of the angle between the direction of view and the ground plane. The angle is larger
/// than half of the angle of view.
constexpr double least_sine = 0.28;

constexpr std::array<View, 6> views_of_axes{View::right, View::left, View::back,
                                            View::front, View::top,  View::bottom};

struct Angle {
  double sine;
  double cosine;

  static Angle of_sine(double sine) { return {sine, square_root(1 - sine * sine)}; }
  /// Multiples of 90 degrees give exact numbers.
  static Angle of_degrees(double degrees) {
    const auto sine = [](double angle) {
      if (std::fmod(angle, 180) == 0) return 0.0;
      return std::sin(angle / 180 * std::numbers::pi);
    };
    return {sine(degrees), sine(90 - degrees)};
  }
};

/// The camera's elevation and its azimuth (to the right).
struct Turn {
  Angle elevation;
  Angle azimuth;

  /// Returns the turn with the angles that the user gives.
  [[nodiscard]] Turn replaced_by(const Turning& turning) const {
    return {turning.elevation ? Angle::of_degrees(*turning.elevation) : elevation,
            turning.azimuth ? Angle::of_degrees(*turning.azimuth) : azimuth};
  }
};
constexpr Turn no_turn{{0, 1}, {0, 1}};

/// 17 and 12 degrees.
Turn molecule_turn() { return {Angle::of_sine(0.3), Angle::of_sine(0.2)}; }
/// 20 and 27 degrees: a box shows three sides.
Turn box_turn() { return {Angle::of_sine(0.35), Angle::of_sine(0.45)}; }

/// Returns the frame after a rotation about `up` and a rotation about `right`.
Axes turned(const Axes& frame, const Turn& turn) {
  const auto& [elevation, azimuth] = turn;
  const Vec3d level = azimuth.cosine * frame.back + azimuth.sine * frame.right;
  Axes view;
  view.center = frame.center;
  view.right = azimuth.cosine * frame.right - azimuth.sine * frame.back;
  view.back = elevation.cosine * level + elevation.sine * frame.up;
  view.up = elevation.cosine * frame.up - elevation.sine * level;
  return view;
}

/// Turns a vector about the unit vector `axis`. Source: Rodrigues' formula.
Vec3d rotated(const Vec3d& v, const Vec3d& axis, const Angle& angle) {
  return angle.cosine * v + angle.sine * cross(axis, v) +
         ((1 - angle.cosine) * dot(axis, v)) * axis;
}
Axes rotated(const Axes& frame, const Vec3d& axis, const Angle& angle) {
  return {rotated(frame.right, axis, angle), rotated(frame.up, axis, angle),
          rotated(frame.back, axis, angle), frame.center};
}

/// Turns a vector about the axis of a turntable.
Vec3d turned_direction(const Vec3d& v, const Vec3d& up, double degrees) {
  const double angle = degrees / 180 * std::numbers::pi;
  return rotated(v, up, {std::sin(angle), std::cos(angle)});
}

class Reach {
 public:
  Reach(std::span<const Sphere> spheres, const Axes& axes) : axes_{axes.right, axes.up, axes.back} {
    for (const Sphere& sphere : spheres) {
      for (std::size_t i = 0; i < 3; ++i) {
        extents_[i].add(dot(sphere.center, axes_[i]));
      }
    }
  }

  [[nodiscard]] Vec3d middle() const {
    Vec3d middle;
    for (std::size_t i = 0; i < 3; ++i) {
      middle = middle + ((extents_[i].low + extents_[i].high) / 2) * axes_[i];
    }
    return middle;
  }
  /// Returns the axis along which the centres are flat, if any. A group that is thin along two axes
  /// is a rod, which is not flat.
  [[nodiscard]] std::optional<std::size_t> flat_axis() const {
    std::array<std::size_t, 3> order{0, 1, 2};
    const auto extent = [&](std::size_t i) { return extents_[i].high - extents_[i].low; };
    std::ranges::stable_sort(order, {}, extent);
    const bool rod = extent(order[1]) <= flatness * extent(order[2]);
    return !rod && extent(order[0]) <= flatness * extent(order[1]) ? std::optional(order[0])
                                                                   : std::nullopt;
  }

 private:
  std::array<Vec3d, 3> axes_;
  std::array<NumberBounds, 3> extents_;
};

constexpr Axes coordinates{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {}};

Axes around(Axes frame, const Vec3d& center) {
  frame.center = center;
  return frame;
}

/// Returns the rotation that turns z to `up`, as the images of x, -y and z in `right`, `back` and
/// `up`.
Axes upright(const Vec3d& up) {
  const Vec3d upwards = normalize(up);
  const bool along_x = upwards.y == 0 && upwards.z == 0;
  const Vec3d across = along_x ? Vec3d{0, 1, 0} : Vec3d{1, 0, 0};
  const Vec3d right = normalize(across - dot(across, upwards) * upwards);
  return {right, upwards, cross(right, upwards), {}};
}

/// Returns the axes of a view of a scene whose upward direction is `up`.
Axes axes_of(View view, const std::optional<Vec3d>& up) {
  const Axes axes = axes_of(view);
  if (!up) return axes;
  const Axes turn = upright(*up);
  const auto image = [&](const Vec3d& v) {
    return v.x * turn.right + v.z * turn.up - v.y * turn.back;
  };
  return {image(axes.right), image(axes.up), image(axes.back), {}};
}

/// Returns a viewpoint with a floor if the camera looks down steeply enough, otherwise with a wall.
Viewpoint above_ground(const Axes& frame, const Vec3d& up) {
  return {frame, dot(frame.back, up) >= least_sine ? up : frame.back};
}

/// Returns the view of a flat group, which looks at it unless the user turns it.
Viewpoint face_on(const Axes& frame, const Turning& turning) {
  if (turning.empty()) return {frame, frame.back};
  return above_ground(turned(frame, no_turn.replaced_by(turning)), frame.up);
}

Viewpoint automatic_view(std::span<const Sphere> spheres, bool molecule, const Turning& turning) {
  const Reach reach(spheres, coordinates);
  if (turning.up) {
    const Axes front = around(axes_of(View::front, turning.up), reach.middle());
    return above_ground(turned(front, box_turn().replaced_by(turning)), front.up);
  }
  if (!molecule) {
    constexpr std::array<View, 3> across{View::right, View::front, View::top};
    const auto flat = reach.flat_axis();
    if (flat) return face_on(around(axes_of(across[*flat]), reach.middle()), turning);
  }
  const Axes principal = principal_axes(spheres);
  if (Reach(spheres, principal).flat_axis() == std::size_t{2}) {
    Axes exact = principal;
    exact.back = principal_axes(spheres, false).back;
    exact.right = normalize(cross(principal.up, exact.back));
    exact.up = cross(exact.back, exact.right);
    return face_on(exact, turning);
  }
  const Axes level = molecule ? principal : around(axes_of(View::front), reach.middle());
  const Turn turn = molecule ? molecule_turn() : box_turn();
  return above_ground(turned(level, turn.replaced_by(turning)), level.up);
}

/// Turns a named view by the user's angles. `up` is the scene's upward direction.
Axes turned_by(const Turning& turning, View view, const Axes& frame, const Vec3d& up) {
  const bool steep = view == View::top || view == View::bottom;
  const Vec3d axis = steep ? frame.up : up;
  const Turn rise = no_turn.replaced_by({.elevation = turning.elevation});
  const Axes aside = rotated(frame, axis, Angle::of_degrees(turning.azimuth.value_or(0)));
  const Axes risen = turned(aside, rise);
  constexpr double rounding = 1e-9;
  if (dot(risen.up, axis) < -rounding) {
    throw InputError("--elevation " + number_text(*turning.elevation) + ": the view " +
                     std::string(name_of(view)) +
                     " would turn over the top: use a smaller angle, or another view");
  }
  return risen;
}

}  // namespace

View view_from(std::string_view name) {
  if (const auto axis = place_in(view_axes, name)) return views_of_axes.at(*axis);
  std::vector<std::string_view> known(view_names.begin(), view_names.end());
  known.insert(known.end(), view_axes.begin(), view_axes.end());
  return static_cast<View>(known_place("view", name, known));
}

std::string_view name_of(View view) { return view_names[static_cast<std::size_t>(view)]; }

Axes axes_of(View view) {
  switch (view) {  // no negative zeros, because files do not keep their sign
    case View::front: return {{1, 0, 0}, {0, 0, 1}, {0, -1, 0}, {}};
    case View::back: return {{-1, 0, 0}, {0, 0, 1}, {0, 1, 0}, {}};
    case View::left: return {{0, -1, 0}, {0, 0, 1}, {-1, 0, 0}, {}};
    case View::right: return {{0, 1, 0}, {0, 0, 1}, {1, 0, 0}, {}};
    case View::bottom: return {{-1, 0, 0}, {0, 1, 0}, {0, 0, -1}, {}};
    case View::iso: {
      const Vec3d right = normalize(Vec3d{3, 2, 0});
      const Vec3d back = normalize(Vec3d{4, -6, 3});
      return {right, cross(back, right), back, {}};
    }
    case View::top:
    case View::automatic: break;
  }
  return coordinates;
}

Vec3d up_from(std::string_view text) {
  const std::string_view axis = text.starts_with('+') ? text.substr(1) : text;
  if (axis == "x") return {1, 0, 0};
  if (axis == "y") return {0, 1, 0};
  if (axis == "z") return {0, 0, 1};
  if (axis == "-x") return {-1, 0, 0};
  if (axis == "-y") return {0, -1, 0};
  if (axis == "-z") return {0, 0, -1};
  std::vector<double> parts;
  for (const std::string_view part : split_at(',', text)) {
    const auto value = parsed_between(part, ranges::coordinate.least, ranges::coordinate.most);
    if (value) parts.push_back(*value);
  }
  const bool three = parts.size() == 3 && std::ranges::count(text, ',') == 2;
  const double largest =
      three ? std::max({std::abs(parts[0]), std::abs(parts[1]), std::abs(parts[2])}) : 0;
  if (largest == 0) {
    throw InputError("'" + printable(text) +
                     "' is not a direction: write x, y, z, -x, -y, -z, or three numbers such as "
                     "0,1,1");
  }
  return {parts[0] / largest, parts[1] / largest, parts[2] / largest};
}

Viewpoint viewpoint_of(std::span<const Sphere> spheres, View view, bool molecule,
                       const Turning& turning) {
  if (view == View::automatic) return automatic_view(spheres, molecule, turning);
  const Axes frame = around(axes_of(view, turning.up), Reach(spheres, coordinates).middle());
  const Vec3d up = turning.up ? normalize(*turning.up) : Vec3d{0, 0, 1};
  const bool turns = turning.azimuth || turning.elevation;
  return above_ground(turns ? turned_by(turning, view, frame, up) : frame, up);
}

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
