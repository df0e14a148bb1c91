#pragma once

#include "common/image/pixel_sums.h"
#include "common/trace/integrator/camera_rays.h"
#include "common/trace/integrator/material.h"
#include "common/trace/sphere_search.h"

/// Traces one sample in scalar code: this file defines the bits of a picture. The parameters have
/// template types. So the functions work with the containers of a host (CPU) and with the tables of
/// a device (GPU).
namespace parray::trace {

/// Everything that a path can meet. Spheres are numbered first, then capsules. `material_of` holds
/// the material of each shape. TraceScene is one for hosts.
template <typename S, typename Real>
concept PathScene = requires(const S& scene, std::uint32_t i) {
  { scene.spheres.size() } -> std::convertible_to<std::uint64_t>;
  { scene.spheres[i] } -> std::convertible_to<SphereShape<Real>>;
  { scene.capsules.size() } -> std::convertible_to<std::uint64_t>;
  { scene.capsules[i] } -> std::convertible_to<CapsuleShape<Real>>;
  { scene.material_of[i] } -> std::convertible_to<std::uint32_t>;
  { scene.surfaces[i] } -> std::convertible_to<MaterialParameters<Real>>;
  { scene.sky } -> std::convertible_to<SkyGradient<Real>>;
};

/// Returns the number of spheres, which is also the number of the first capsule.
std::uint32_t sphere_count(const auto& scene) {
  return static_cast<std::uint32_t>(scene.spheres.size());
}

/// Returns visit(shape) for the sphere or capsule with this number.
template <typename Scene, typename Visit>
auto at_shape(const Scene& scene, std::uint32_t number, const Visit& visit) {
  return number < sphere_count(scene) ? visit(scene.spheres[number])
                                      : visit(scene.capsules[number - sphere_count(scene)]);
}

/// Returns the parameter at which a ray leaves a shape that the path is inside of.
template <typename Real, typename List, PathScene<Real> Scene>
Real exit_of(const Scene& scene, const Ray<Real>& ray, const InsideStack<Real, List>& sides,
             std::uint32_t number) {
  if (number < sphere_count(scene) && sides.stands_on(number)) {
    return chord_from_surface<Real>(ray, scene.spheres[number], sides.normal());
  }
  return at_shape(scene, number, [&](const auto& shape) { return exit_distance(ray, shape); });
}

/// Returns the first crossing along a ray: out of a shape that the path is inside of, or into
/// another shape. Tries capsules one after the other, unless `search` finds them.
template <typename Real, typename List, PathScene<Real> Scene,
          EntrySearch<Real, InsideStack<Real, List>> Search>
Hit<Real> first_crossing(const Scene& scene, const Search& search, const Ray<Real>& ray,
                         const InsideStack<Real, List>& sides) {
  Hit<Real> best;
  for (const std::uint32_t index : sides.inside()) {
    const Real t = exit_of(scene, ray, sides, index);
    if (best.loses_to(t, index)) best = {t, index, true};
  }
  search.enter(ray, sides, best);
  if constexpr (requires { search.enter_capsules(ray, sides, best); }) {
    search.enter_capsules(ray, sides, best);
  } else {
    for (std::uint32_t i = 0; i < scene.capsules.size(); ++i) {
      try_shape<Real>(ray, scene.capsules[i], sphere_count(scene) + i, sides, best);
    }
  }
  return best;
}

/// Returns the place of a crossing on the surface of its shape.
template <typename Real, typename List, PathScene<Real> Scene>
SurfacePoint<Real> surface_point(const Scene& scene, const Ray<Real>& ray,
                                 const InsideStack<Real, List>& sides, const Hit<Real>& hit) {
  if (hit.shape >= sphere_count(scene)) {
    return surface_point<Real>(ray, scene.capsules[hit.shape - sphere_count(scene)], hit.leaving);
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
template <typename Real, typename List, PathScene<Real> Scene>
bool is_within_body(const Scene& scene, const InsideStack<Real, List>& sides,
                    std::uint32_t number) {
  const std::uint32_t material = scene.material_of[number];
  if (scene.surfaces[material].type != MaterialType::dielectric) return false;
  for (const std::uint32_t other : sides.inside()) {
    if (other != number && scene.material_of[other] == material) return true;
  }
  return false;
}

static_assert(TraceCounts::rays_of_segment == most_crossings + 1);

/// Returns the first crossing along a ray with a surface that bounds a body (see InsideStack), or
/// with the surface after most_crossings others. Moves `ray` and `sides` straight through the
/// surfaces before it, and adds the ray and its parts to counts.rays.
template <typename Real, typename List, PathScene<Real> Scene, typename Search>
Hit<Real> next_surface(const Scene& scene, const Search& search, Ray<Real>& ray,
                       InsideStack<Real, List>& sides, TraceCounts& counts) {
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

/// Puts a new path of pixel (x, y) inside the shapes that contain its origin. `ends.start.of(x, y)`
/// lists the shapes that may.
template <typename Real, typename List, PathScene<Real> Scene, typename Ends>
void start_sides(const Scene& scene, const Ends& ends, std::uint32_t x, std::uint32_t y,
                 const Vec3<Real>& origin, InsideStack<Real, List>& sides) {
  sides.start();
  for (const std::uint32_t index : ends.start.of(x, y)) {
    if (at_shape(scene, index, [&](const auto& shape) { return contains(shape, origin); })) {
      sides.cross(index, false);
    }
  }
}

/// A path between two surfaces.
template <typename Real>
struct Path {
  Ray<Real> ray;                   ///< to the next surface
  Vec3<Real> throughput{1, 1, 1};  ///< product of the albedos so far
  std::uint32_t bounce = 0;        ///< number of surfaces met
};

/// Begins the path of a sample of pixel (x, y). `ends` has the camera (`view`), the shapes at the
/// start (see start_sides) and `max_depth`. PathEnds is one for hosts.
template <typename Real, typename List, PathScene<Real> Scene, typename Ends>
PARRAY_INLINE Path<Real> begin_path(const Scene& scene, const Ends& ends, std::uint32_t x,
                                    std::uint32_t y, const SampleRandom& random,
                                    InsideStack<Real, List>& sides) {
  const Path<Real> path{ends.view.template ray<Real>(x, y, random)};
  start_sides(scene, ends, x, y, path.ray.origin, sides);
  return path;
}

/// Moves a path to its next surface and scatters it there. Returns whether the path goes on. If
/// not, sets `radiance` if the path has reached the sky; otherwise leaves it as it is. Adds to
/// counts.rays and counts.lost.
template <typename Real, typename List, PathScene<Real> Scene, typename Ends, typename Search>
PARRAY_INLINE bool advance(const Scene& scene, const Ends& ends, const Search& search,
                           const SampleRandom& random, Path<Real>& path,
                           InsideStack<Real, List>& sides, Vec3<Real>& radiance,
                           TraceCounts& counts) {
  Ray<Real>& ray = path.ray;
  const Hit<Real> hit = next_surface(scene, search, ray, sides, counts);
  if (hit.shape == no_shape) {
    radiance = path.throughput * scene.sky.radiance(ray.direction.y);
    return false;
  }
  const SurfacePoint<Real> point = surface_point(scene, ray, sides, hit);
  const Vec3<Real>& normal = point.normal;
  const MaterialParameters<Real>& surface = scene.surfaces[scene.material_of[hit.shape]];
  auto scattering = scatter(surface, ray.direction, hit.leaving ? -normal : normal, hit.leaving,
                            random, path.bounce);
  if (is_within_body(scene, sides, hit.shape)) scattering = {Event::refracted, ray.direction};
  if (scattering.event == Event::absorbed) return false;
  if (scattering.event == Event::refracted) {
    sides.cross(hit.shape, hit.leaving);
  } else {
    path.throughput = path.throughput * surface.albedo;
  }
  sides.stand_on(hit.shape, normal);
  ray = {point.position(), scattering.direction};
  if (++path.bounce < ends.max_depth) return true;
  const Vec3<Real>& throughput = path.throughput;
  counts.lost += TraceCounts::lost_of(
      static_cast<double>(max_of(max_of(throughput.x, throughput.y), throughput.z)));
  return false;  // longer than max_depth: counts as dark
}

/// Returns the radiance of one sample of pixel (x, y), and counts as advance() does. `sides` is
/// scratch memory. If sides.overflowed() afterwards, the result is unknown.
template <typename Real, typename List, PathScene<Real> Scene, typename Ends, typename Search>
Vec3<Real> trace_sample(const Scene& scene, const Ends& ends, const Search& search, std::uint32_t x,
                        std::uint32_t y, const SampleRandom& random, InsideStack<Real, List>& sides,
                        TraceCounts& counts) {
  Path<Real> path = begin_path(scene, ends, x, y, random, sides);
  Vec3<Real> radiance{};
  while (advance(scene, ends, search, random, path, sides, radiance, counts)) {
  }
  return radiance;
}

}  // namespace parray::trace
