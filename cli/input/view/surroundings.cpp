#include "cli/input/view/surroundings.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <numbers>

#include "cli/input/color/number_bounds.h"
#include "cli/input/scene_file/scene_sections.h"
#include "common/base/bands.h"
#include "common/base/error.h"
#include "common/base/printable.h"
#include "common/math/largest_component.h"
#include "common/scene/limits.h"

namespace parray::input {
namespace {

/// Degrees; a long lens, so that near parts look no larger than far ones.
constexpr double auto_scene_vfov = 20;

/// Extremes of the spheres along one axis of the picture, measured along lines through the eye.
///
/// A sphere at (x, z), with z towards the eye, lies inside a half-plane through the eye at (ex, ez)
/// with the slope t if x + t z + r sqrt(1 + t^2) <= ex + t ez. The other side uses -x, -ex and a
/// slope of its own. For t = 0 the lines are parallel: extents of an orthographic camera.
struct Wedge {
  struct Side {
    explicit Side(double tangent) : t(tangent), secant(square_root(1 + tangent * tangent)) {}

    void add(double x, double z, double radius) {
      reach = std::max(reach, t * z + radius * secant + x);
    }

    double t;
    double secant;
    double reach = -std::numeric_limits<double>::infinity();
  };

  /// The slopes of the sides towards smaller and towards larger x.
  Wedge(double low_tangent, double high_tangent) : low(low_tangent), high(high_tangent) {}

  void add(double x, double z, double radius) {
    high.add(x, z, radius);
    low.add(-x, z, radius);
  }
  void add(const Wedge& other) {
    high.reach = std::max(high.reach, other.high.reach);
    low.reach = std::max(low.reach, other.low.reach);
  }
  [[nodiscard]] double width() const { return high.reach + low.reach; }
  /// The nearest z of an eye that sees the whole wedge (low.t + high.t > 0).
  [[nodiscard]] double distance() const { return width() / (low.t + high.t); }
  /// The x of an eye for which the wedge is in the middle of the picture.
  [[nodiscard]] double middle() const { return (high.reach - low.reach) / 2; }
  /// The x of an eye, as near to middle() as possible, that sees the wedge between `least` and
  /// `most`: places in the picture relative to its middle, as lengths at z = 0.
  [[nodiscard]] double middle_between(double least, double most) const {
    if (least == -most) return middle();
    return std::max(high.reach - most, std::min(middle(), -least - low.reach));
  }

  Side low;
  Side high;
};

/// Returns the slope of a line through the eye to a place of the picture, from 0 in the middle to 1
/// at the edge of the picture's height.
double slope_of(Projection projection, double place) {
  return projection == Projection::orthographic ? 0 : place * tan_half_of(auto_scene_vfov);
}

/// The extremes of all spheres. They do not depend on the order of the spheres.
struct Extent {
  /// Of a picture in which the spheres are in `area`. `aspect` is the width of the picture divided
  /// by its height.
  Extent(Projection projection, double aspect, const PictureArea& area)
      : vertical(slope_of(projection, -area.bottom), slope_of(projection, area.top)),
        horizontal(slope_of(projection, -area.left) * aspect,
                   slope_of(projection, area.right) * aspect) {}

  void add(const Sphere& sphere, const Viewpoint& view) {
    const Vec3d p = sphere.center - view.frame.center;
    const double z = dot(p, view.frame.back);
    horizontal.add(dot(p, view.frame.right), z, sphere.radius);
    vertical.add(dot(p, view.frame.up), z, sphere.radius);
    reach = std::max(reach, length(p) + sphere.radius);
    add_lowest(sphere, dot(p, view.off_ground) - sphere.radius);
  }
  /// Adds the extremes of spheres that come after the spheres of this object.
  void add(const Extent& later) {
    horizontal.add(later.horizontal);
    vertical.add(later.vertical);
    reach = std::max(reach, later.reach);
    add_lowest(later.lowest, later.bottom);
  }
  void add_lowest(const Sphere& sphere, double low) {
    if (!(low < bottom)) return;
    bottom = low;
    lowest = sphere;
  }

  Wedge vertical;
  Wedge horizontal;
  double reach = 0;  ///< radius of the ball around the frame's centre that contains all spheres
  double bottom = std::numeric_limits<double>::infinity();
  Sphere lowest{};  ///< the sphere that reaches farthest towards the ground; the first of several
};

/// What the picture shows, and in which form.
struct Shot {
  std::span<const Sphere> spheres;
  /// More spheres: ends of capsules, and points such as the corners of a cell.
  std::vector<Sphere> others;
  Viewpoint view;
  Projection projection;
  double aspect;  ///< width of the picture divided by its height
};

/// Returns the extremes of spheres, capsules and points. The result is the same for any number of
/// threads.
Extent extent_of(const Shot& shot, const PictureArea& area, int threads) {
  const Extent none(shot.projection, shot.aspect, area);
  const Bands bands(shot.spheres.size(), threads);
  std::vector<Extent> parts(bands.count(), none);
  bands.run([&](std::size_t band, std::size_t begin, std::size_t end) {
    Extent part = none;
    for (const Sphere& sphere : shot.spheres.subspan(begin, end - begin)) {
      part.add(sphere, shot.view);
    }
    parts[band] = part;
  });
  Extent whole = none;
  for (const Extent& part : parts) whole.add(part);
  for (const Sphere& sphere : shot.others) whole.add(sphere, shot.view);
  return whole;
}

TurnAxis axis_of(const Viewpoint& view) {
  const bool wall = view.off_ground == view.frame.back;
  return {view.frame.center, wall ? view.frame.up : view.off_ground};
}

/// Returns the middle of the spheres' extents along the coordinate axes.
Vec3d middle_of(std::span<const Sphere> spheres) {
  PositionBounds bounds{spheres.front().center};
  for (const Sphere& sphere : spheres) bounds.add(sphere.center);
  return 0.5 * bounds.low + 0.5 * bounds.high;
}

std::vector<Sphere> all_around(const std::vector<Sphere>& spheres, const TurnAxis& axis) {
  constexpr int angles = 60;
  std::vector<Sphere> around;
  for (int i = 0; i < angles; ++i) {
    for (Sphere sphere : spheres) {
      sphere.center = turned(sphere.center, axis, 360.0 * i / angles);
      around.push_back(sphere);
    }
  }
  return around;
}

/// Decides the direction of view by `spheres`, and what the picture includes.
Shot shot_of(std::span<const Sphere> spheres, double aspect, const Viewing& viewing,
             const Subject& subject) {
  const Projection projection = viewing.projection.value_or(
      viewing.view == View::automatic ? Projection::perspective : Projection::orthographic);
  Shot shot{spheres, viewing.other_spheres,
            viewpoint_of(spheres, viewing.view, subject.molecule, viewing.turning), projection,
            aspect};
  for (const auto* points : {&subject.corners, &viewing.other_points}) {
    for (const Vec3d& point : *points) shot.others.push_back({point, 0, 0});
  }
  if (!viewing.other_spheres.empty()) shot.view.frame.center = middle_of(shot.others);
  for (const Capsule& capsule : subject.capsules) {
    shot.others.push_back({capsule.from, capsule.radius, 0});
    shot.others.push_back({capsule.to, capsule.radius, 0});
  }
  if (viewing.turns) shot.others = all_around(shot.others, axis_of(shot.view));
  return shot;
}

/// Zooms in: the picture becomes smaller than before. The middle of the extent stays where it is in
/// the picture. `middle` is its place in the coordinates of `center`, the eye's place.
void zoom_in(Camera& camera, double zoom, const Vec3d& middle, Vec3d& center) {
  center = center + (1 - 1 / zoom) * (middle - center);
  if (camera.projection == Projection::orthographic) {
    camera.view_height /= zoom;
    return;
  }
  constexpr double half_turn = 180;
  camera.vfov = 2 * std::atan(camera.tan_half_vfov / zoom) / std::numbers::pi * half_turn;
  camera.tan_half_vfov = tan_half_of(camera.vfov);
}

/// Returns a pinhole camera that shows `extent` in `area`, for which the extent was measured. Along
/// the tighter axis, the extent fills the area. `zoom` above 1 shows a part of it.
Camera camera_for(const Shot& shot, const Extent& extent, const PictureArea& area, double zoom) {
  const Wedge& horizontal = extent.horizontal;
  const Wedge& vertical = extent.vertical;
  const double aspect = shot.aspect;
  Camera camera;
  camera.projection = shot.projection;
  const double tangent = tan_half_of(auto_scene_vfov);
  double half_height = 0;  // of the picture, at the frame's centre
  if (shot.projection == Projection::orthographic) {
    camera.vfov = 0;
    camera.view_height = std::max(vertical.width() / (area.height() / 2),
                                  horizontal.width() / aspect / (area.width() / 2));
    half_height = camera.view_height / 2;
    // The distance of a perspective camera keeps the camera above the ground. The second term keeps
    // it in front of every sphere.
    camera.focus_distance = std::max(camera.view_height / (2 * tangent), 2 * extent.reach);
  } else {
    camera.vfov = auto_scene_vfov;
    camera.tan_half_vfov = tangent;
    camera.focus_distance = std::max(horizontal.distance(), vertical.distance());
    half_height = tangent * camera.focus_distance;
  }
  const double half_width = half_height * aspect;
  Vec3d center{horizontal.middle_between(half_width * area.left, half_width * area.right),
               vertical.middle_between(half_height * area.bottom, half_height * area.top), 0};
  if (zoom > 1) zoom_in(camera, zoom, {horizontal.middle(), vertical.middle(), 0}, center);
  const Axes& frame = shot.view.frame;
  camera.look_at = frame.center + center.x * frame.right + center.y * frame.up;
  camera.look_from = camera.look_at + camera.focus_distance * frame.back;
  camera.up =
      frame.up + Vec3d{};  // turns negative zeros into zeros, because files do not keep their sign
  camera.aperture = 0;
  return camera;
}

/// A camera, and what the places of the scenery depend on.
struct Framing {
  Camera camera;
  Extent extent;
  /// Size of the scenery relative to that of a picture without labels and zoom. The scenery grows
  /// with the distance of the camera, so that it fills the picture.
  double growth = 1;
};

/// Frames the spheres: without labels first, because labels depend on the camera, then in the area
/// that the labels leave free.
Framing framing_of(const Shot& shot, double zoom, const Subject& subject, int threads) {
  const double shrink = std::min(zoom, 1.0);
  Extent extent = extent_of(shot, usual_area, threads);
  Camera camera = camera_for(shot, extent, usual_area, zoom);
  const double usual_distance = camera.focus_distance;
  PictureArea area = usual_area;
  if (subject.labels) {
    area = free_area(subject.labels(camera), extent.horizontal.width() / shot.aspect,
                     extent.vertical.width());
  }
  if (shrink < 1) area = scaled(area, shrink);
  if (area == usual_area) return {camera, extent};
  extent = extent_of(shot, area, threads);
  camera = camera_for(shot, extent, area, zoom);
  constexpr double rise = 2;  // a camera that rises sees farther over the ground
  return {camera, extent, rise * std::max(camera.focus_distance / usual_distance, 1.0)};
}

constexpr std::string_view ground_name = "ground";
constexpr std::string_view wall_name = "wall";
constexpr Material pale{MaterialType::diffuse, {0.75, 0.75, 0.75}, 0, 1};
constexpr Material black{MaterialType::diffuse, {0, 0, 0}, 0, 1};
constexpr Material dark{MaterialType::diffuse, {0.006, 0.008, 0.014}, 0, 1};  ///< sRGB 17, 22, 31
// Lengths in radii of the group of spheres:
constexpr double ground_radius = 500;  ///< so large that it looks flat
constexpr double far = 400;  ///< distance of a light blocker and a wall: beyond any camera
constexpr double studio_blocker_radius = 300;  ///< covers 49 degrees around its direction
constexpr double free_blocker_radius = 345;    ///< covers 60 degrees: no floor reflects light

/// Directions in the axes of the picture: right, up, towards the viewer.
constexpr Vec3d studio_blocker{0.85, 0, 0.5};
constexpr Vec3d free_blocker{0.62, -0.62, 0.48};

/// The ground touches the lowest sphere; all other spheres lie above its tangent plane. On a
/// turntable its centre lies on the axis.
Sphere ground_below(const Extent& extent, double reach, const Viewpoint& view, bool turns) {
  const double radius = ground_radius * reach;
  const Sphere& lowest = extent.lowest;
  if (turns) return {view.frame.center + (extent.bottom - radius) * view.off_ground, radius, 0};
  return {lowest.center - (lowest.radius + radius) * view.off_ground, radius, 0};
}

Sphere light_blocker(const Axes& view, double reach, bool free) {
  const Vec3d towards = free ? free_blocker : studio_blocker;
  const Vec3d direction = normalize(towards);
  Vec3d offset = direction.x * view.right + direction.z * view.back;
  if (direction.y != 0) offset = offset + direction.y * view.up;
  return {view.center + (far * reach) * offset,
          (free ? free_blocker_radius : studio_blocker_radius) * reach, 0};
}

/// Covers slightly more than the camera sees. The sky around the wall lights the edges of the
/// particles.
Sphere wall_behind(const Axes& view, double reach, const Camera& camera, double aspect) {
  constexpr double least_sine = 0.6;
  constexpr double most_sine = 0.97;  // keeps the wall behind the group
  // The tangent of half of the picture's diagonal angle, plus a tenth.
  const double tangent = 1.1 * tan_half_of(auto_scene_vfov) * square_root(1 + aspect * aspect);
  const double sine =
      std::clamp(tangent / square_root(1 + tangent * tangent), least_sine, most_sine);
  const double distance = far * reach;
  const double radius = std::min(sine * (distance + camera.focus_distance), distance - 2 * reach);
  return {view.center - distance * view.back, radius, 0};
}

void check(const Surroundings& around) {
  const Camera& camera = around.camera;
  double reach = std::max({largest_component(camera.look_from), largest_component(camera.look_at),
                           camera.focus_distance, camera.view_height});
  for (const SceneryObject& object : around.scenery) {
    reach = std::max({reach, largest_component(object.sphere.center), object.sphere.radius});
  }
  if (reach > limits::max_length) {
    throw InputError("the camera and the ground of the automatic scene would reach " +
                     number_text(reach) + ", above the limit of " +
                     number_text(limits::max_length) + ": scale the coordinates down");
  }
  const double distance = length(camera.look_from - camera.look_at);
  constexpr double most_rounding = 1e-3;
  if (std::abs(distance - camera.focus_distance) > most_rounding * camera.focus_distance) {
    throw InputError(
        "the particles are too far from the origin for their size: move them closer to it");
  }
}

bool has_ground(const Viewing& viewing) {
  return viewing.style == Style::studio && !viewing.transparent;
}

}  // namespace

std::vector<SceneryObject> scenery_of(const Viewing& viewing) {
  std::vector<SceneryObject> scenery;
  if (has_ground(viewing)) scenery.push_back({ground_name, pale});
  if (viewing.style == Style::night && !viewing.transparent) scenery.push_back({wall_name, dark});
  if (viewing.style != Style::flat) scenery.push_back({"flag", black});
  return scenery;
}

Surroundings surroundings_of(std::span<const Sphere> spheres, double aspect, const Viewing& viewing,
                             const Subject& subject, int threads) {
  const Shot shot = shot_of(spheres, aspect, viewing, subject);
  const auto& [camera, extent, growth] = framing_of(shot, viewing.zoom, subject, threads);
  const double reach = extent.reach * growth;
  Surroundings around;
  around.camera = camera;
  around.sky = sky_of(viewing.style);
  around.scenery = scenery_of(viewing);
  around.axis = axis_of(shot.view);
  for (SceneryObject& object : around.scenery) {
    if (object.name == ground_name) {
      object.sphere = ground_below(extent, reach, shot.view, viewing.turns);
    } else if (object.name == wall_name) {
      object.sphere = wall_behind(shot.view.frame, reach, around.camera, aspect);
    } else {
      object.sphere = light_blocker(shot.view.frame, reach, !has_ground(viewing));
    }
  }
  check(around);
  return around;
}

}  // namespace parray::input
