#include "cli/input/view/surroundings.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <span>
#include <vector>

#include "cli/input/scene_file/scene_sections.h"
#include "common/base/bands.h"
#include "common/base/error.h"
#include "common/base/printable.h"
#include "common/scene/limits.h"

namespace parray::input {
namespace {

inline constexpr double auto_scene_vfov =
    20;  ///< degrees; a long lens, so that near parts look no larger than far ones

/// Extremes of the spheres along one axis of the picture, measured along lines through the eye.
///
/// A sphere at (x, z), with z towards the eye, lies inside a half-plane through the eye at (ex, ez)
/// with the slope t if x + t z + r sqrt(1 + t^2) <= ex + t ez. The other side uses -x and -ex. For
/// t = 0 the lines are parallel: extents of an orthographic camera.
struct Wedge {
  explicit Wedge(double tangent) : t(tangent), secant(square_root(1 + tangent * tangent)) {}

  void add(double x, double z, double radius);
  void add(const Wedge& other);
  /// The nearest z of an eye that sees the whole wedge (t > 0), and the x that centres the wedge.
  [[nodiscard]] double distance() const { return (right + left) / (2 * t); }
  [[nodiscard]] double middle() const { return (right - left) / 2; }
  [[nodiscard]] double width() const { return right + left; }  ///< for t = 0

  double t;
  double secant;
  double right = -std::numeric_limits<double>::infinity();
  double left = -std::numeric_limits<double>::infinity();
};

/// The extremes of all spheres. They do not depend on the order of the spheres.
struct Extent {
  Extent(Projection projection, double aspect);

  void add(const Sphere& sphere, const Viewpoint& view);
  /// Adds the extremes of spheres that come after the spheres of this object.
  void add(const Extent& later);

  Wedge vertical;
  Wedge horizontal;
  double reach = 0;  ///< radius of the ball around the frame's centre that contains all spheres
  double bottom = std::numeric_limits<double>::infinity();
  Sphere lowest{};  ///< the sphere that reaches farthest towards the ground; the first of several
};

constexpr double filled = 0.85;  ///< share of the picture's width or height that the spheres fill

double tangent_of(Projection projection) {
  return projection == Projection::orthographic ? 0 : filled * tan_half_of(auto_scene_vfov);
}

void Wedge::add(double x, double z, double radius) {
  const double depth = t * z + radius * secant;
  right = std::max(right, x + depth);
  left = std::max(left, depth - x);
}

void Wedge::add(const Wedge& other) {
  right = std::max(right, other.right);
  left = std::max(left, other.left);
}

Extent::Extent(Projection projection, double aspect)
    : vertical(tangent_of(projection)), horizontal(tangent_of(projection) * aspect) {}

void Extent::add(const Sphere& sphere, const Viewpoint& view) {
  const Vec3d p = sphere.center - view.frame.center;
  const double z = dot(p, view.frame.back);
  horizontal.add(dot(p, view.frame.right), z, sphere.radius);
  vertical.add(dot(p, view.frame.up), z, sphere.radius);
  reach = std::max(reach, length(p) + sphere.radius);
  const double low = dot(p, view.off_ground) - sphere.radius;
  if (low < bottom) {
    bottom = low;
    lowest = sphere;
  }
}

void Extent::add(const Extent& later) {
  horizontal.add(later.horizontal);
  vertical.add(later.vertical);
  reach = std::max(reach, later.reach);
  if (later.bottom < bottom) {
    bottom = later.bottom;
    lowest = later.lowest;
  }
}

/// Returns the extremes of spheres and points, such as the corners of a cell. `aspect` is the width
/// of the picture divided by its height. The result is the same for any number of threads.
Extent extent_of(std::span<const Sphere> spheres, std::span<const Vec3d> points,
                 const Viewpoint& view, Projection projection, double aspect, int threads) {
  const Extent none(projection, aspect);
  const Bands bands(spheres.size(), threads);
  std::vector<Extent> parts(bands.count(), none);
  bands.run([&](std::size_t band, std::size_t begin, std::size_t end) {
    Extent part = none;
    for (const Sphere& sphere : spheres.subspan(begin, end - begin)) part.add(sphere, view);
    parts[band] = part;
  });
  Extent whole = none;
  for (const Extent& part : parts) whole.add(part);
  for (const Vec3d& point : points) whole.add({point, 0, 0}, view);
  return whole;
}

/// Returns a pinhole camera that shows `extent` in the middle 85 % of its picture. Along the
/// tighter axis, the extent fills these 85 %.
Camera camera_for(const Extent& extent, const Viewpoint& view, Projection projection,
                  double aspect) {
  const Wedge& horizontal = extent.horizontal;
  const Wedge& vertical = extent.vertical;
  Camera camera;
  camera.projection = projection;
  const double tangent = tan_half_of(auto_scene_vfov);
  if (projection == Projection::orthographic) {
    camera.vfov = 0;
    camera.view_height = std::max(vertical.width(), horizontal.width() / aspect) / filled;
    // The distance of a perspective camera keeps the camera above the ground. The second term keeps
    // it in front of every sphere.
    camera.focus_distance = std::max(camera.view_height / (2 * tangent), 2 * extent.reach);
  } else {
    camera.vfov = auto_scene_vfov;
    camera.tan_half_vfov = tangent;
    camera.focus_distance = std::max(horizontal.distance(), vertical.distance());
  }
  const Axes& frame = view.frame;
  camera.look_at = frame.center + horizontal.middle() * frame.right + vertical.middle() * frame.up;
  camera.look_from = camera.look_at + camera.focus_distance * frame.back;
  camera.up =
      frame.up + Vec3d{};  // turns negative zeros into zeros, because files do not keep their sign
  camera.aperture = 0;
  return camera;
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

Sphere ground_below(const Extent& extent, const Viewpoint& view) {
  // The ground touches the lowest sphere; all other spheres lie above its tangent plane.
  const double radius = ground_radius * extent.reach;
  const Sphere& lowest = extent.lowest;
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

double largest_component(const Vec3d& v) {
  return std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)});
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
  const Viewpoint view = viewpoint_of(spheres, viewing.view, subject.molecule);
  const Projection projection = viewing.projection.value_or(
      viewing.view == View::automatic ? Projection::perspective : Projection::orthographic);
  const Extent extent = extent_of(spheres, subject.corners, view, projection, aspect, threads);
  Surroundings around;
  around.camera = camera_for(extent, view, projection, aspect);
  around.sky = sky_of(viewing.style);
  around.scenery = scenery_of(viewing);
  for (SceneryObject& object : around.scenery) {
    if (object.name == ground_name) {
      object.sphere = ground_below(extent, view);
    } else if (object.name == wall_name) {
      object.sphere = wall_behind(view.frame, extent.reach, around.camera, aspect);
    } else {
      object.sphere = light_blocker(view.frame, extent.reach, !has_ground(viewing));
    }
  }
  check(around);
  return around;
}

}  // namespace parray::input
