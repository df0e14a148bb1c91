#include "cli/input/view/view.h"

#include <algorithm>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "common/base/suggest.h"
#include "common/base/text.h"

namespace parray::input {
namespace {

constexpr double flatness =
    0.1;  ///< largest ratio of the third extent to the second for a flat group
/// Least sine of the angle between the direction of view and the ground plane. The angle is larger
/// than half of the angle of view.
constexpr double least_sine = 0.28;

constexpr std::array<View, 6> views_of_axes{View::right, View::left, View::back,
                                            View::front, View::top,  View::bottom};

/// Sines of the camera's elevation and azimuth (to the right).
struct Turn {
  double elevation;
  double azimuth;
};
constexpr Turn molecule_turn{0.3, 0.2};  ///< 17 and 12 degrees
constexpr Turn box_turn{0.35, 0.45};     ///< 20 and 27 degrees: a box shows three sides

/// Returns the frame after a rotation about `up` and a rotation about `right`.
Axes turned(const Axes& frame, const Turn& turn) {
  const auto cosine = [](double sine) { return square_root(1 - sine * sine); };
  const Vec3d level = cosine(turn.azimuth) * frame.back + turn.azimuth * frame.right;
  Axes view;
  view.center = frame.center;
  view.right = cosine(turn.azimuth) * frame.right - turn.azimuth * frame.back;
  view.back = cosine(turn.elevation) * level + turn.elevation * frame.up;
  view.up = cosine(turn.elevation) * frame.up - turn.elevation * level;
  return view;
}

/// Extents of centres along three axes.
class Reach {
 public:
  Reach(std::span<const Sphere> spheres, const Axes& axes) : axes_{axes.right, axes.up, axes.back} {
    for (const Sphere& sphere : spheres) {
      for (std::size_t i = 0; i < 3; ++i) {
        const double x = dot(sphere.center, axes_[i]);
        low_[i] = std::min(low_[i], x);
        high_[i] = std::max(high_[i], x);
      }
    }
  }

  [[nodiscard]] Vec3d middle() const {
    Vec3d middle;
    for (std::size_t i = 0; i < 3; ++i) middle = middle + ((low_[i] + high_[i]) / 2) * axes_[i];
    return middle;
  }
  /// Returns the axis along which the centres are flat, if any. A group that is thin along two axes
  /// is a rod, which is not flat.
  [[nodiscard]] std::optional<std::size_t> flat_axis() const {
    std::array<std::size_t, 3> order{0, 1, 2};
    const auto extent = [&](std::size_t i) { return high_[i] - low_[i]; };
    std::ranges::stable_sort(order, {}, extent);
    const bool rod = extent(order[1]) <= flatness * extent(order[2]);
    return !rod && extent(order[0]) <= flatness * extent(order[1]) ? std::optional(order[0])
                                                                   : std::nullopt;
  }

 private:
  std::array<Vec3d, 3> axes_;
  std::array<double, 3> low_ = filled(std::numeric_limits<double>::infinity());
  std::array<double, 3> high_ = filled(-std::numeric_limits<double>::infinity());

  static std::array<double, 3> filled(double x) { return {x, x, x}; }
};

/// The coordinate axes: x right, y up, z back.
constexpr Axes coordinates{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {}};

Axes around(Axes frame, const Vec3d& center) {
  frame.center = center;
  return frame;
}

Viewpoint face_on(const Axes& frame) { return {frame, frame.back}; }

Viewpoint automatic_view(std::span<const Sphere> spheres, bool molecule) {
  const Reach reach(spheres, coordinates);
  if (!molecule) {
    constexpr std::array<View, 3> across{View::right, View::front, View::top};
    const auto flat = reach.flat_axis();
    if (flat) return face_on(around(axes_of(across[*flat]), reach.middle()));
  }
  const Axes principal = principal_axes(spheres);
  if (Reach(spheres, principal).flat_axis() == std::size_t{2}) {
    Axes exact = principal;
    exact.back = principal_axes(spheres, false).back;
    exact.right = normalize(cross(principal.up, exact.back));
    exact.up = cross(exact.back, exact.right);
    return face_on(exact);
  }
  if (molecule) return {turned(principal, molecule_turn), principal.up};
  const Axes front = around(axes_of(View::front), reach.middle());
  return {turned(front, box_turn), front.up};
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
    case View::front:
      return {{1, 0, 0}, {0, 0, 1}, {0, -1, 0}, {}};
    case View::back:
      return {{-1, 0, 0}, {0, 0, 1}, {0, 1, 0}, {}};
    case View::left:
      return {{0, -1, 0}, {0, 0, 1}, {-1, 0, 0}, {}};
    case View::right:
      return {{0, 1, 0}, {0, 0, 1}, {1, 0, 0}, {}};
    case View::bottom:
      return {{-1, 0, 0}, {0, 1, 0}, {0, 0, -1}, {}};
    case View::iso: {
      const Vec3d right = normalize(Vec3d{1, 1, 0});
      const Vec3d back = normalize(Vec3d{1, -1, 1});
      return {right, cross(back, right), back, {}};
    }
    case View::top:
    case View::automatic:
      break;
  }
  return coordinates;
}

Viewpoint viewpoint_of(std::span<const Sphere> spheres, View view, bool molecule) {
  if (view == View::automatic) return automatic_view(spheres, molecule);
  const Axes frame = around(axes_of(view), Reach(spheres, coordinates).middle());
  const Vec3d up{0, 0, 1};
  return {frame, dot(frame.back, up) >= least_sine ? up : frame.back};
}

}  // namespace parray::input
