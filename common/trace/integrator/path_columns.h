#pragma once

#include <cstdint>

#include "common/trace/bvh/ray_columns.h"
#include "common/trace/integrator/kernel_scene.h"

/// The scratch memory of a batch: the state of each path, in columns. Nothing is initialised.
namespace parray::trace {

/// The paths that continue, each with its next ray.
template <typename Real>
struct Paths : RayColumns<Real> {
  VecColumns<Real> throughput;   ///< product of the albedos so far
  Column<std::uint32_t> sample;  ///< number in the batch
};

/// The paths that have met a surface of one type of material, or the sky.
template <typename Real>
struct Hits {
  std::uint32_t count;  ///< of paths
  VecColumns<Real> origin, direction, throughput;
  Column<Real> inverse_square;
  /// Number of the sample in the batch, slot of the shape, number of its material.
  Column<std::uint32_t> sample, slot, material;
  // Only used if paths can be inside a shape.
  Column<Real> side;  ///< 0: into the shape, 1: out of it, 2: out of it from its own surface
  Column<std::uint32_t> inside;  ///< first link of its list in InsideLists
  // Only used for paths on side 2.
  VecColumns<Real> old_normal;  ///< outward normal of the surface that the path stood on
  Column<Real> t;
};

/// All scratch memory of the kernels for one batch.
template <typename Real, typename Store>
struct Workspace : TraversalSpace<Real, Store> {
  Paths<Real> paths;
  static constexpr std::uint32_t sky = 3;
  Hits<Real> hits[4];  ///< by MaterialType, then the sky
  BatchRadiance radiance;
  Column<std::uint32_t> pixel;                   ///< pixel of each sample of the batch
  const std::uint32_t* sample_number = nullptr;  ///< number of each sample; memory of the batch
};

/// Returns the list, in `inside`, of the shapes that contain the start of a path of pixel (x, y).
template <typename Real, typename Store, int W>
PARRAY_INLINE std::uint32_t inside_at(const KernelScene<Real, Store, W>& scene, std::uint32_t x,
                                      std::uint32_t y, const Vec3<Real>& origin,
                                      InsideLists& inside) {
  std::uint32_t head = InsideLists::none;
  if (scene.start.numbers == nullptr) return head;
  const std::uint32_t tile = scene.start.tile(x, y);
  for (std::uint32_t k = scene.start.begins[tile]; k < scene.start.begins[tile + 1]; ++k) {
    const std::uint32_t slot = scene.start.numbers[k];
    const bool in = slot < scene.bvh.end_slot
                        ? contains(shape_at<Real>(scene.bvh.blocks, slot), origin)
                        : contains(scene.capsule_at(slot), origin);
    if (in) head = inside.push(head, slot);
  }
  return head;
}

}  // namespace parray::trace
