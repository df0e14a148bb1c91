#include "cli/input/view/portrait.h"

#include <algorithm>
#include <cmath>

#include "cli/input/scene_file/scene_sections.h"
#include "cli/input/view/framing.h"
#include "common/base/error.h"
#include "common/base/printable.h"
#include "common/scene/limits.h"

namespace parray::input {
namespace {

constexpr std::string_view ground_name = "ground";
constexpr std::string_view wall_name = "wall";
constexpr Material pale{MaterialType::diffuse, {0.75, 0.75, 0.75}, 0, 1};
constexpr Material black{MaterialType::diffuse, {0, 0, 0}, 0, 1};
constexpr Material dark{MaterialType::diffuse, {0.006, 0.008, 0.014}, 0, 1};  ///< sRGB 17, 22, 31
// In radii of the group:
constexpr double ground_radius = 500;       ///< flat to the eye
constexpr double far = 400;                 ///< of a flag and a wall: beyond any camera
constexpr double studio_flag_radius = 300;  ///< 49 degrees around its direction
constexpr double free_flag_radius = 345;    ///< 60 degrees: no floor is below to give light back

/// As the picture sees them: right, up, towards the viewer.
constexpr Vec3d studio_flag{0.85, 0, 0.5};
constexpr Vec3d free_flag{0.62, -0.62, 0.48};

Sphere ground_below(const Extent& extent, const Viewpoint& view) {
  // Tangent to the plane that the lowest sphere stands on: all others are above that.
  const double radius = ground_radius * extent.reach;
  const Sphere& lowest = extent.lowest;
  return {lowest.center - (lowest.radius + radius) * view.off_ground, radius, 0};
}

Sphere flag_beside(const Axes& view, double reach, bool free) {
  const Vec3d towards = free ? free_flag : studio_flag;
  const Vec3d direction = normalize(towards);
  Vec3d offset = direction.x * view.right + direction.z * view.back;
  if (direction.y != 0) offset = offset + direction.y * view.up;
  return {view.center + (far * reach) * offset,
          (free ? free_flag_radius : studio_flag_radius) * reach, 0};
}

/// Covers what the camera sees, and little more: what it does not cover gives light to the rims.
Sphere wall_behind(const Axes& view, double reach, const Camera& camera, double aspect) {
  constexpr double least_sine = 0.6;
  constexpr double most_sine = 0.97;  // nothing of it is before the group
  // Of half of the picture's diagonal, with a tenth more.
  const double tangent = 1.1 * tan_half_of(portrait_vfov) * square_root(1 + aspect * aspect);
  const double sine =
      std::clamp(tangent / square_root(1 + tangent * tangent), least_sine, most_sine);
  const double distance = far * reach;
  const double radius = std::min(sine * (distance + camera.focus_distance), distance - 2 * reach);
  return {view.center - distance * view.back, radius, 0};
}

double largest_component(const Vec3d& v) {
  return std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)});
}

void check(const Portrait& portrait) {
  const Camera& camera = portrait.camera;
  double reach = std::max({largest_component(camera.look_from), largest_component(camera.look_at),
                           camera.focus_distance, camera.view_height});
  for (const Prop& prop : portrait.props) {
    reach = std::max({reach, largest_component(prop.sphere.center), prop.sphere.radius});
  }
  if (reach > limits::max_length) {
    throw InputError("camera and ground of a portrait would reach " + number_text(reach) +
                     ", beyond " + number_text(limits::max_length) +
                     ": scale the coordinates down");
  }
  const double distance = length(camera.look_from - camera.look_at);
  constexpr double most_rounding = 1e-3;
  if (std::abs(distance - camera.focus_distance) > most_rounding * camera.focus_distance) {
    throw InputError("the particles are too far from the origin for their size: move them nearer");
  }
}

bool has_ground(const Viewing& viewing) {
  return viewing.style == Style::studio && !viewing.transparent;
}

}  // namespace

std::vector<Prop> props_of(const Viewing& viewing) {
  std::vector<Prop> props;
  if (has_ground(viewing)) props.push_back({ground_name, pale});
  if (viewing.style == Style::night && !viewing.transparent) props.push_back({wall_name, dark});
  if (viewing.style != Style::flat) props.push_back({"flag", black});
  return props;
}

Portrait portrait_of(std::span<const Sphere> spheres, double aspect, const Viewing& viewing,
                     const Subject& subject, int threads) {
  const Viewpoint view = viewpoint_of(spheres, viewing.view, subject.molecule);
  const Projection projection = viewing.projection.value_or(
      viewing.view == View::automatic ? Projection::perspective : Projection::orthographic);
  const Extent extent = extent_of(spheres, subject.corners, view, projection, aspect, threads);
  Portrait portrait;
  portrait.camera = camera_for(extent, view, projection, aspect);
  portrait.sky = sky_of(viewing.style);
  portrait.props = props_of(viewing);
  for (Prop& prop : portrait.props) {
    if (prop.name == ground_name) {
      prop.sphere = ground_below(extent, view);
    } else if (prop.name == wall_name) {
      prop.sphere = wall_behind(view.frame, extent.reach, portrait.camera, aspect);
    } else {
      prop.sphere = flag_beside(view.frame, extent.reach, !has_ground(viewing));
    }
  }
  check(portrait);
  return portrait;
}

}  // namespace parray::input
