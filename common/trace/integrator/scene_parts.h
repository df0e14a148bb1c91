#pragma once

#include <vector>

#include "common/math/real.h"
#include "common/scene/scene.h"
#include "common/scene/setting_choices.h"
#include "common/trace/capsule.h"
#include "common/trace/integrator/camera_rays.h"
#include "common/trace/integrator/material.h"
#include "common/trace/integrator/path_tracer.h"

/// The parts of a scene that all accelerators and tracers make in the same way.
namespace parray::trace {

/// Calls visit<Real, Store>() with the types of a precision, which must not be `automatic`: that of
/// path computations and that of stored shapes. Returns its result.
auto with_types(Precision precision, const auto& visit) {
  switch (precision) {
    case Precision::f64: return visit.template operator()<double, double>();
    case Precision::mixed: return visit.template operator()<double, float>();
    default: return visit.template operator()<float, float>();
  }
}

/// Returns a sphere in the form that an accelerator stores, relative to `origin`.
template <typename Store>
SphereShape<Store> stored_shape(const Sphere& sphere, const Vec3d& origin) {
  return {vec_cast<Store>(sphere.center - origin), static_cast<Store>(sphere.radius)};
}

/// Returns a capsule in the form that an accelerator stores, relative to `origin`.
template <typename Store>
CapsuleShape<Store> stored_shape(const Capsule& capsule, const Vec3d& origin) {
  return {vec_cast<Store>(0.5 * (capsule.from + capsule.to) - origin),
          vec_cast<Store>(0.5 * (capsule.to - capsule.from)), static_cast<Store>(capsule.radius)};
}

/// Returns the scene's materials, in its order, in the form that kernels read.
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

/// Fills `first` for a camera ray that hits nothing.
template <typename Real>
void set_sky(const Ray<Real>& ray, FirstHit& first) {
  first.shape = no_shape;
  first.distance = 0;
  first.direction = vec_cast<double>(ray.direction);
  first.normal = {};
}

/// Fills `first` for a camera ray that hits a shape. `outward` is the outward unit normal of the
/// surface at the hit, and hit.shape the shape's number in the scene. The function sets the fields
/// one by one. To make a FirstHit and copy it would be slower: the processor waits when it loads,
/// in larger pieces, what it has just stored.
template <typename Real>
void set_hit(const Ray<Real>& ray, const Hit<Real>& hit, const Vec3<Real>& outward,
             FirstHit& first) {
  first.shape = hit.shape;
  first.distance = static_cast<double>(hit.t);
  first.direction = vec_cast<double>(ray.direction);
  first.normal = vec_cast<double>(hit.leaving ? -outward : outward);
}

}  // namespace parray::trace
