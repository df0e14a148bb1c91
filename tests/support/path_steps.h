#pragma once

#include <cstdint>
#include <vector>

#include "common/scene/settings.h"
#include "common/trace/integrator/path.h"
#include "common/trace/reference/scalar_tracer.h"
#include "tests/support/quad.h"
#include "tests/support/reference_tracer.h"
#include "tests/support/rooms.h"

/// One path, step by step, through the tracer's own templates.
namespace parray::test {

/// The scene with 113 bits. Its spheres are not rounded, except when the origin is subtracted from
/// them in double precision, as in every kernel.
inline TracedPicture<Quad> exact_scene(const Scene& scene, const RenderSettings& settings) {
  TracedPicture<Quad> result = reference_scene<Quad, double>(scene, settings);
  const Vec3d origin = scene_origin(scene);
  for (std::size_t i = 0; i < scene.spheres.size(); ++i) {
    const Sphere& sphere = scene.spheres[i];
    result.spheres[i] = {exact(sphere.center - origin), Quad(sphere.radius)};
  }
  return result;
}

/// What happened to a path at one surface.
struct Step {
  std::uint32_t shape = no_shape;
  bool leaving = false;
  Event event = Event::absorbed;

  friend bool operator==(const Step&, const Step&) = default;
};

/// Follows one path for at most scene.max_depth segments. Calls `look(ray, hit, scattering)` at
/// every surface. Returns true if the path reached the sky; `ray` is then its last ray.
template <typename Real, typename Look>
bool follow(const TracedPicture<Real>& scene, const Linear<Real>& linear, Ray<Real>& ray,
            InsideStack<Real>& sides, const SampleRandom& random, Look look) {
  for (std::uint32_t bounce = 0; bounce < scene.max_depth; ++bounce) {
    const Hit<Real> hit = first_crossing(scene, linear, ray, sides);
    if (hit.shape == no_shape) return true;
    const SurfacePoint<Real> point = surface_point(scene, ray, sides, hit);
    const Vec3<Real>& normal = point.normal;
    const auto scattering = scatter(scene.surfaces[scene.material_of[hit.shape]], ray.direction,
                                    hit.leaving ? -normal : normal, hit.leaving, random, bounce);
    look(ray, hit, scattering);
    if (scattering.event == Event::absorbed) return false;
    if (scattering.event == Event::refracted) sides.cross(hit.shape, hit.leaving);
    sides.stand_on(hit.shape, normal);
    ray = {point.position(), scattering.direction};
  }
  return false;
}

/// Returns the surfaces that a sample's path meets, in order.
template <typename Real>
std::vector<Step> steps_of(const TracedPicture<Real>& scene, const Linear<Real>& linear,
                           std::uint32_t x, std::uint32_t y, const SampleRandom& random) {
  Ray<Real> ray = scene.view.template ray<Real>(x, y, random);
  InsideStack<Real> sides;
  start_sides(scene, scene, x, y, ray.origin, sides);
  std::vector<Step> steps;
  follow(scene, linear, ray, sides, random,
         [&steps](const Ray<Real>&, const Hit<Real>& hit, const Scattering<Real>& scattering) {
           steps.push_back({hit.shape, hit.leaving, scattering.event});
         });
  return steps;
}

}  // namespace parray::test
