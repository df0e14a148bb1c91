#pragma once

#include <cstdint>
#include <vector>

#include "common/math/real.h"
#include "common/scene/scene.h"
#include "common/scene/settings_fwd.h"
#include "common/trace/integrator/camera_rays.h"
#include "common/trace/integrator/material.h"
#include "common/trace/integrator/path_tracer.h"
#include "common/trace/sphere.h"

/// The parts of a scene that all accelerators and tracers make in the same way.
namespace parray::trace {

/// Returns a sphere in the form that an accelerator stores, relative to `origin`.
template <typename Store>
SphereShape<Store> stored_shape(const Sphere& sphere, const Vec3d& origin) {
  return {vec_cast<Store>(sphere.center - origin), static_cast<Store>(sphere.radius)};
}

/// Returns all spheres in that form.
template <typename Store>
std::vector<SphereShape<Store>> stored_shapes(const Scene& scene, const Vec3d& origin) {
  std::vector<SphereShape<Store>> shapes;
  shapes.reserve(scene.spheres.size());
  for (const Sphere& sphere : scene.spheres) {
    shapes.push_back(stored_shape<Store>(sphere, origin));
  }
  return shapes;
}

template <typename Real>
std::vector<MaterialParameters<Real>> stored_materials(const Scene& scene) {
  return {scene.materials.begin(), scene.materials.end()};
}

/// Returns the camera relative to `origin`.
inline Camera moved(Camera camera, const Vec3d& origin) {
  camera.look_from = camera.look_from - origin;
  camera.look_at = camera.look_at - origin;
  return camera;
}

/// Sets the first hit of a camera ray that meets nothing.
template <typename Real>
void set_sky(const Ray<Real>& ray, FirstHit& first) {
  first.sphere = no_sphere;
  first.distance = 0;
  first.direction = vec_cast<double>(ray.direction);
  first.normal = {};
}

/// Sets the first hit of a camera ray; `sphere` is the sphere of `hit`. The function sets the
/// fields one by one: a copy of the whole stalls, because its parts have just been stored.
template <typename Real>
void set_hit(const Ray<Real>& ray, const Hit<Real>& hit, const SphereShape<Real>& sphere,
             FirstHit& first) {
  const Vec3<Real> outward = normal_at(ray, sphere, hit.leaving);
  first.sphere = hit.sphere;
  first.distance = static_cast<double>(hit.t);
  first.direction = vec_cast<double>(ray.direction);
  first.normal = vec_cast<double>(hit.leaving ? -outward : outward);
}

}  // namespace parray::trace
