#include "cli/input/view/framing.h"

#include <algorithm>
#include <vector>

#include "cli/input/scene_file/scene_sections.h"
#include "common/base/bands.h"

namespace parray::input {
namespace {

constexpr double filled = 0.85;  ///< part of the picture's width or height

double tangent_of(Projection projection) {
  return projection == Projection::orthographic ? 0 : filled * tan_half_of(portrait_vfov);
}

}  // namespace

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

Camera camera_for(const Extent& extent, const Viewpoint& view, Projection projection,
                  double aspect) {
  const Wedge& horizontal = extent.horizontal;
  const Wedge& vertical = extent.vertical;
  Camera camera;
  camera.projection = projection;
  const double tangent = tan_half_of(portrait_vfov);
  if (projection == Projection::orthographic) {
    camera.vfov = 0;
    camera.view_height = std::max(vertical.width(), horizontal.width() / aspect) / filled;
    // As far as a perspective camera would be, so above the ground, and before every sphere.
    camera.focus_distance = std::max(camera.view_height / (2 * tangent), 2 * extent.reach);
  } else {
    camera.vfov = portrait_vfov;
    camera.tan_half_vfov = tangent;
    camera.focus_distance = std::max(horizontal.distance(), vertical.distance());
  }
  const Axes& frame = view.frame;
  camera.look_at = frame.center + horizontal.middle() * frame.right + vertical.middle() * frame.up;
  camera.look_from = camera.look_at + camera.focus_distance * frame.back;
  camera.up = frame.up + Vec3d{};  // a negative zero, which files do not keep, becomes zero
  camera.aperture = 0;
  return camera;
}

}  // namespace parray::input
