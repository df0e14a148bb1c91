#pragma once

#include <cstdint>

#include "common/trace/bvh/ray_columns.h"
#include "common/trace/integrator/kernel_scene.h"

/// The scratch memory of a batch: what is known of each path, in columns. Nothing is initialised.
namespace parray::trace {

/// Paths that go on, each with its next ray.
template <typename Real>
struct Paths : RayColumns<Real> {
  VecColumns<Real> throughput;
  Column<std::uint32_t> sample;  ///< number in the batch
};

/// Paths that have met a surface of one type of material, or the sky.
template <typename Real>
struct Hits {
  std::uint32_t count;
  VecColumns<Real> origin, direction, throughput;
  Column<Real> inverse_square;
  Column<std::uint32_t> sample, slot, material;
  // Only where paths can be inside something.
  Column<Real> side;  ///< 0: into the sphere, 1: out of it, 2: the same from its own surface
  Column<std::uint32_t> inside;
  // Only of those on side 2.
  VecColumns<Real> old_normal;  ///< of the surface that the path stood on
  Column<Real> t;
};

template <typename Real, typename Store>
struct Workspace : TraversalSpace<Real, Store> {
  Paths<Real> paths;
  static constexpr std::uint32_t sky = 3;
  Hits<Real> hits[4];  ///< by MaterialType, then those of the sky
  BatchRadiance radiance;
  Column<std::uint32_t> pixel;                   ///< of each sample of the batch
  const std::uint32_t* sample_number = nullptr;  ///< of each: the batch's
};

/// The spheres that the start of a path of pixel (x, y) lies in, as a list in `inside`.
template <typename Real, typename Store, int W>
PARRAY_INLINE std::uint32_t inside_at(const KernelScene<Real, Store, W>& scene, std::uint32_t x,
                                      std::uint32_t y, const Vec3<Real>& origin,
                                      InsideLists& inside) {
  std::uint32_t head = InsideLists::none;
  if (scene.start.numbers == nullptr) return head;
  const std::uint32_t tile = scene.start.tile(x, y);
  for (std::uint32_t k = scene.start.begins[tile]; k < scene.start.begins[tile + 1]; ++k) {
    const std::uint32_t slot = scene.start.numbers[k];
    const auto sphere = sphere_at<Real>(scene.bvh.blocks, slot);
    const Vec3<Real> from_center = origin - sphere.center;
    if (dot(from_center, from_center) < sphere.radius * sphere.radius) {
      head = inside.push(head, slot);
    }
  }
  return head;
}

}  // namespace parray::trace
