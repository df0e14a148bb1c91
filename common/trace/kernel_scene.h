#pragma once

#include <cstdint>

#include "common/trace/material.h"
#include "common/trace/sphere.h"
#include "common/trace/view.h"

/// A scene as the kernels of an instruction set read it: plain tables, filled by scene_tables.cpp
/// and owned by it. Spheres are named by their slot, their place in the tables.
///
/// `Real` is what a path is computed in, `Store` what spheres and boxes are stored in: float float
/// is precision f32, double float is mixed, double double is f64. `W`, the width of a node and of a
/// block, is the number of `Store` lanes that the instruction set has.
namespace parray {

/// Up to W spheres side by side. Lanes without a sphere hold NaN, which no ray meets.
template <typename Store, int W>
struct alignas(64) SphereBlock {
  Store x[W];
  Store y[W];
  Store z[W];
  Store radius[W];
};

/// What a child of a node is: the number of a node, or of a block of spheres where `is_block` is
/// set. `is_end` stands for no child at the bottom of a stack.
struct ChildRef {
  static constexpr std::uint32_t is_block = 0x80000000;
  static constexpr std::uint32_t is_end = 0x40000000;
  static constexpr std::uint32_t number = 0x7FFFFFFF;
};

/// The sphere in a slot.
template <typename Real, typename Store, int W>
PARRAY_INLINE SphereShape<Real> sphere_at(const SphereBlock<Store, W>* blocks, std::uint32_t slot) {
  const SphereBlock<Store, W>& block = blocks[slot / W];
  const std::uint32_t lane = slot % W;
  return {{Real(block.x[lane]), Real(block.y[lane]), Real(block.z[lane])},
          Real(block.radius[lane])};
}

/// A node with up to W children. Bounds of absent children are empty: no ray meets them, unless it
/// is not a number; that one ends there.
template <typename Store, int W>
struct alignas(64) WideNode {
  Store planes[6][W];        ///< lower x, y, z, then upper x, y, z of each child
  std::uint32_t child[W];    ///< see ChildRef
  std::uint8_t order[8][W];  ///< children far to near for rays of each octant (bit: axis is < 0)
};

/// A sphere's material: the number of its surface, and the surface's MaterialType from bit
/// `type_bit` on.
struct MaterialRef {
  static constexpr int type_bit = 30;
  static constexpr std::uint32_t number = (1U << type_bit) - 1;
};

/// What a scene does not contain, its kernel leaves out.
struct KernelFeatures {
  bool sides = true;  ///< a path can be inside a sphere: there is glass, or a sphere at the lens
  bool fuzz = true;   ///< some metal is not a perfect mirror

  friend bool operator==(const KernelFeatures&, const KernelFeatures&) = default;
};

template <typename Real, typename Store, int W>
struct KernelScene {
  KernelScene(const View<Real>& v, const SkyGradient<Real>& s) : view(v), sky(s) {}

  View<Real> view;
  SkyGradient<Real> sky;
  std::uint32_t width = 0;  ///< of the picture, pixels
  std::uint32_t max_depth = 1;
  std::uint64_t seed = 0;
  Sampler sampler = Sampler::independent;
  double to_fixed = 1;  ///< RadianceScale::factor()
  KernelFeatures features;

  const Surface<Real>* surfaces = nullptr;        ///< by material
  const std::uint32_t* material_of = nullptr;     ///< by slot: see MaterialRef
  const std::uint32_t* input_index = nullptr;     ///< by slot: ties go to the lower one
  const SphereBlock<Store, W>* blocks = nullptr;  ///< the first ones are in no node
  std::uint32_t open_spheres = 0;                 ///< in those, in input order
  const WideNode<Store, W>* nodes = nullptr;      ///< the root is the first
  std::uint32_t node_count = 0;
  std::uint32_t stack_size = 0;                ///< pending children that a ray can have
  bool prefetch = false;                       ///< the tables are larger than the caches
  const std::uint32_t* around_lens = nullptr;  ///< slots whose inside the lens reaches
  std::uint32_t around_lens_count = 0;
};

/// Samples of one row of the picture.
struct SampleBatch {
  static constexpr std::uint32_t most = 512;        ///< paths that are traced side by side
  static constexpr std::uint32_t room = most + 16;  ///< whole vectors are read

  std::uint32_t y = 0;
  std::uint32_t count = 0;                      ///< 1 .. most
  alignas(64) std::uint32_t column[room] = {};  ///< x of each
  alignas(64) std::uint32_t sample[room] = {};  ///< its number within the pixel
};

/// Radiance of each sample of a batch, in the fixed point of RadianceScale: as fixed_of() takes it;
/// NaN where it is not finite.
struct BatchRadiance {
  std::uint64_t lost = 0;  ///< added to: see TraceCounts
  alignas(64) double channel[3][SampleBatch::most];
};

}  // namespace parray
