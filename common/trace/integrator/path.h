#pragma once

#include <algorithm>

#include "common/image/pixel_sums.h"
#include "common/trace/integrator/camera_rays.h"
#include "common/trace/integrator/material.h"
#include "common/trace/integrator/start_shapes.h"
#include "common/trace/sphere_search.h"

namespace parray::trace {

/// Everything that a path can meet. Immutable; all threads and all pictures of the scene share it.
template <typename Real>
struct TraceScene {
  std::vector<SphereShape<Real>> spheres;
  std::vector<CapsuleShape<Real>> capsules;  ///< numbered after the spheres
  std::vector<std::uint32_t> material_of;    ///< material of each shape
  std::vector<MaterialParameters<Real>> surfaces;
  SkyGradient<Real> sky;

  [[nodiscard]] std::uint32_t shape_count() const {
    return static_cast<std::uint32_t>(spheres.size() + capsules.size());
  }
  /// Returns visit(shape) for the sphere or capsule with this number.
  template <typename Visit>
  auto at_shape(std::uint32_t number, const Visit& visit) const {
    return number < spheres.size() ? visit(spheres[number])
                                   : visit(capsules[number - spheres.size()]);
  }
};

/// The camera, start spheres and maximum depth of a picture's paths. Immutable; all threads share
/// it.
template <typename Real>
struct PathEnds {
  CameraRays<Real> view;
  StartShapes start;  ///< nearly always empty
  std::uint32_t max_depth = 1;
};

/// Returns the parameter at which a ray leaves a shape that the path is inside of.
template <typename Real>
Real exit_of(const TraceScene<Real>& scene, const Ray<Real>& ray, const InsideStack<Real>& sides,
             std::uint32_t number) {
  if (number < scene.spheres.size() && sides.stands_on(number)) {
    return chord_from_surface(ray, scene.spheres[number], sides.normal());
  }
  return scene.at_shape(number, [&](const auto& shape) { return exit_distance(ray, shape); });
}

/// Returns the first crossing along a ray: out of a shape that the path is inside of, or into
/// another shape. `search` finds spheres. Capsules are tried one after the other.
template <typename Real, SphereSearch<Real> S>
Hit<Real> first_crossing(const TraceScene<Real>& scene, const S& search, const Ray<Real>& ray,
                         const InsideStack<Real>& sides) {
  Hit<Real> best;
  for (const std::uint32_t index : sides.inside()) {
    const Real t = exit_of(scene, ray, sides, index);
    if (best.loses_to(t, index)) {
      best = {t, index, true};
    }
  }
  search.enter(ray, sides, best);
  auto number = static_cast<std::uint32_t>(scene.spheres.size());
  for (const CapsuleShape<Real>& capsule : scene.capsules) {
    try_shape(ray, capsule, number++, sides, best);
  }
  return best;
}

/// Returns the place of a crossing on the surface of its shape.
template <typename Real>
SurfacePoint<Real> surface_point(const TraceScene<Real>& scene, const Ray<Real>& ray,
                                 const InsideStack<Real>& sides, const Hit<Real>& hit) {
  if (hit.shape >= scene.spheres.size()) {
    return surface_point(ray, scene.capsules[hit.shape - scene.spheres.size()], hit.leaving);
  }
  const SphereShape<Real>& sphere = scene.spheres[hit.shape];
  if (hit.leaving && sides.stands_on(hit.shape)) {
    return {normalize(sphere.radius * sides.normal() + hit.t * ray.direction), sphere.center,
            sphere.radius};
  }
  return {normal_at(ray, sphere, hit.leaving), sphere.center, sphere.radius};
}

/// Returns whether the surface of shape `number` lies inside another body of the same glass, where
/// the path is: see InsideStack.
template <typename Real>
bool is_within_body(const TraceScene<Real>& scene, const InsideStack<Real>& sides,
                    std::uint32_t number) {
  const std::uint32_t material = scene.material_of[number];
  return scene.surfaces[material].type == MaterialType::dielectric &&
         std::ranges::any_of(sides.inside(), [&](std::uint32_t other) {
           return other != number && scene.material_of[other] == material;
         });
}

/// Returns the first crossing along a ray with a surface that bounds a body. Moves `ray` and
/// `sides` straight through the surfaces before it, and counts the rays.
template <typename Real, SphereSearch<Real> S>
Hit<Real> next_surface(const TraceScene<Real>& scene, const S& search, Ray<Real>& ray,
                       InsideStack<Real>& sides, TraceCounts& counts) {
  ++counts.rays;
  Hit<Real> hit = first_crossing(scene, search, ray, sides);
  for (std::uint32_t crossed = 0;
       crossed < most_crossings && hit.shape != no_shape && is_within_body(scene, sides, hit.shape);
       ++crossed) {
    const SurfacePoint<Real> point = surface_point(scene, ray, sides, hit);
    sides.cross(hit.shape, hit.leaving);
    sides.stand_on(hit.shape, point.normal);
    ray = {point.position(), ray.direction};
    ++counts.rays;
    hit = first_crossing(scene, search, ray, sides);
  }
  return hit;
}

/// Puts a new path of pixel (x, y) inside the shapes that contain its origin.
template <typename Real>
void start_sides(const TraceScene<Real>& scene, const PathEnds<Real>& ends, std::uint32_t x,
                 std::uint32_t y, const Vec3<Real>& origin, InsideStack<Real>& sides) {
  sides.start({});
  for (const std::uint32_t index : ends.start.of(x, y)) {
    if (scene.at_shape(index, [&](const auto& shape) { return contains(shape, origin); })) {
      sides.cross(index, false);
    }
  }
}

/// Returns the radiance of one sample of pixel (x, y). Adds to `counts` the path segments and the
/// light that max_depth may have cut off. `sides` is scratch memory, so that paths inside glass do
/// not allocate.
template <typename Real, SphereSearch<Real> S>
Vec3<Real> trace_sample(const TraceScene<Real>& scene, const PathEnds<Real>& ends, const S& search,
                        std::uint32_t x, std::uint32_t y, const SampleRandom& random,
                        InsideStack<Real>& sides, TraceCounts& counts) {
  Ray<Real> ray = ends.view.template ray<Real>(x, y, random);
  start_sides(scene, ends, x, y, ray.origin, sides);
  Vec3<Real> throughput{1, 1, 1};
  for (std::uint32_t bounce = 0; bounce < ends.max_depth; ++bounce) {
    const Hit<Real> hit = next_surface(scene, search, ray, sides, counts);
    if (hit.shape == no_shape) {
      return throughput * scene.sky.radiance(ray.direction.y);
    }
    const SurfacePoint<Real> point = surface_point(scene, ray, sides, hit);
    const Vec3<Real>& normal = point.normal;
    const MaterialParameters<Real>& surface = scene.surfaces[scene.material_of[hit.shape]];
    auto scattering = scatter(surface, ray.direction, hit.leaving ? -normal : normal, hit.leaving,
                              random, bounce);
    if (is_within_body(scene, sides, hit.shape)) scattering = {Event::refracted, ray.direction};
    if (scattering.event == Event::absorbed) {
      return {};
    }
    if (scattering.event == Event::refracted) {
      sides.cross(hit.shape, hit.leaving);
    } else {
      throughput = throughput * surface.albedo;
    }
    sides.stand_on(hit.shape, normal);
    ray = {point.position(), scattering.direction};
  }
  counts.lost += TraceCounts::lost_of(
      static_cast<double>(max_of(max_of(throughput.x, throughput.y), throughput.z)));
  return {};  // longer than max_depth: counts as dark
}

}  // namespace parray::trace
