#include "common/input/portrait/portrait.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "common/base/bands.h"
#include "common/base/error.h"
#include "common/base/printable.h"
#include "common/input/portrait/principal_axes.h"
#include "common/input/scene_sections.h"
#include "common/scene/limits.h"

namespace parray {
namespace {

constexpr double vfov = 20;             ///< degrees: a long lens, so that near atoms look no larger
constexpr double elevation_sine = 0.3;  ///< 17 degrees: beyond half of vfov, so no horizon shows
constexpr double azimuth_sine = 0.2;    ///< 12 degrees: a box shows two sides
constexpr double filled = 0.85;         ///< part of the picture's width or height
constexpr double sky_radiance = 1.15;   ///< a white top is white, a white front a little less
// In radii of the group:
constexpr double ground_radius = 500;  ///< flat to the eye
constexpr double flag_distance = 400;  ///< beyond any camera
constexpr double flag_radius = 300;    ///< 49 degrees around its direction
constexpr double infinity = std::numeric_limits<double>::infinity();

/// The frame as the camera sees it: turned about `up`, then about `right`.
Frame turned(const Frame& frame) {
  const auto cosine = [](double sine) { return square_root(1 - sine * sine); };
  const Vec3d level = cosine(azimuth_sine) * frame.back + azimuth_sine * frame.right;
  Frame view;
  view.center = frame.center;
  view.right = cosine(azimuth_sine) * frame.right - azimuth_sine * frame.back;
  view.back = cosine(elevation_sine) * level + elevation_sine * frame.up;
  view.up = cosine(elevation_sine) * frame.up - elevation_sine * level;
  return view;
}

/// The spheres' extremes along one axis of the picture, as lines through the eye see them.
///
/// A sphere at (x, z), z towards the eye, lies inside a half-plane through the eye at (ex, ez) that
/// leans by the tangent t if x + t z + r sqrt(1 + t^2) <= ex + t ez; and with -x if -ex.
struct Wedge {
  explicit Wedge(double tangent) : t(tangent), secant(square_root(1 + tangent * tangent)) {}

  void add(double x, double z, double radius) {
    const double depth = t * z + radius * secant;
    right = std::max(right, x + depth);
    left = std::max(left, depth - x);
  }
  void add(const Wedge& other) {
    right = std::max(right, other.right);
    left = std::max(left, other.left);
  }
  /// Nearest z of an eye that has everything in the wedge; and the x that centres it.
  [[nodiscard]] double distance() const { return (right + left) / (2 * t); }
  [[nodiscard]] double middle() const { return (right - left) / 2; }

  double t;
  double secant;
  double right = -infinity;
  double left = -infinity;
};

/// What the portrait needs to know of all spheres: extremes, which are the same in any order.
struct Outline {
  Outline(double tangent, double aspect) : vertical(tangent), horizontal(tangent * aspect) {}

  void add(const Sphere& sphere, const Frame& frame, const Frame& view) {
    const Vec3d p = sphere.center - view.center;
    const double z = dot(p, view.back);
    horizontal.add(dot(p, view.right), z, sphere.radius);
    vertical.add(dot(p, view.up), z, sphere.radius);
    reach = std::max(reach, length(p) + sphere.radius);
    const double low = dot(p, frame.up) - sphere.radius;
    if (low < bottom) {
      bottom = low;
      lowest = &sphere;
    }
  }
  /// `later`: of spheres after those of this one.
  void add(const Outline& later) {
    horizontal.add(later.horizontal);
    vertical.add(later.vertical);
    reach = std::max(reach, later.reach);
    if (later.bottom < bottom) {
      bottom = later.bottom;
      lowest = later.lowest;
    }
  }

  Wedge vertical;
  Wedge horizontal;
  double reach = 0;  ///< radius, around the frame's centre, of a ball that holds all spheres
  double bottom = infinity;
  const Sphere* lowest = nullptr;  ///< the first of the lowest
};

Outline outline_of(std::span<const Sphere> spheres, const Frame& frame, const Frame& view,
                   double aspect, int threads) {
  const Outline none(filled * tan_half_of(vfov), aspect);
  const Bands bands(spheres.size(), threads);
  std::vector<Outline> parts(bands.count(), none);
  bands.run([&](std::size_t band, std::size_t begin, std::size_t end) {
    Outline part = none;
    for (const Sphere& sphere : spheres.subspan(begin, end - begin)) part.add(sphere, frame, view);
    parts[band] = part;
  });
  Outline whole = none;
  for (const Outline& part : parts) whole.add(part);
  return whole;
}

Camera camera_for(const Outline& outline, const Frame& view) {
  Camera camera;
  camera.vfov = vfov;
  camera.tan_half_vfov = tan_half_of(vfov);
  const Wedge& horizontal = outline.horizontal;
  const Wedge& vertical = outline.vertical;
  camera.focus_distance = std::max(horizontal.distance(), vertical.distance());
  camera.look_at = view.center + horizontal.middle() * view.right + vertical.middle() * view.up;
  camera.look_from = camera.look_at + camera.focus_distance * view.back;
  camera.up = view.up;
  camera.aperture = 0;
  return camera;
}

Sphere ground_below(const Sphere& lowest, const Frame& frame, double reach) {
  // Tangent to the plane that the lowest sphere stands on: all others are above that.
  const double radius = ground_radius * reach;
  return {lowest.center - (lowest.radius + radius) * frame.up, radius, 0};
}

Sphere flag_beside(const Frame& view, double reach) {
  const Vec3d direction = normalize(Vec3d{0.85, 0, 0.5});
  const Vec3d offset = direction.x * view.right + direction.z * view.back;
  return {view.center + (flag_distance * reach) * offset, flag_radius * reach, 0};
}

double largest_component(const Vec3d& v) {
  return std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)});
}

void check(const Portrait& portrait) {
  const Camera& camera = portrait.camera;
  const double reach =
      std::max({largest_component(camera.look_from), largest_component(camera.look_at),
                camera.focus_distance, largest_component(portrait.ground.center),
                portrait.ground.radius, largest_component(portrait.flag.center)});
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

}  // namespace

Portrait portrait_of(std::span<const Sphere> spheres, double aspect, int threads) {
  const Frame frame = principal_axes(spheres);
  const Frame view = turned(frame);
  const Outline outline = outline_of(spheres, frame, view, aspect, threads);
  Portrait portrait;
  portrait.camera = camera_for(outline, view);
  portrait.sky.horizon = portrait.sky.zenith = {sky_radiance, sky_radiance, sky_radiance};
  portrait.ground = ground_below(*outline.lowest, frame, outline.reach);
  portrait.flag = flag_beside(view, outline.reach);
  check(portrait);
  return portrait;
}

}  // namespace parray
