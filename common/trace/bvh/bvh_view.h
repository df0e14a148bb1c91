#pragma once

#include <cstdint>

#include "common/trace/sphere.h"

/// A tree of spheres as traversal reads it: plain tables, owned and filled by WideBvh. Spheres are
/// named by their slot, their place in the tables.
///
/// `Store` is the type that spheres and boxes are stored in; `W`, the width of a node and of a
/// block, is the number of `Store` lanes that the instruction set has.
namespace parray::trace {

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

/// What is known of a slot besides its sphere, in a word: the sphere's number in the input, in the
/// low bits, and above them a tag, what the owner of the tables has noted there.
struct SlotLabels {
  const std::uint32_t* at = nullptr;  ///< by slot
  std::uint32_t index_mask = 0;       ///< of the low bits; all of them are set where no sphere is

  /// The sphere's number in the input, below index_mask; ties go to the lower one.
  [[nodiscard]] PARRAY_INLINE std::uint32_t index(std::uint32_t slot) const {
    return at[slot] & index_mask;
  }
};

/// The sphere in a slot.
template <typename Real, typename Store, int W>
PARRAY_INLINE SphereShape<Real> sphere_at(const SphereBlock<Store, W>* blocks, std::uint32_t slot) {
  const SphereBlock<Store, W>& block = blocks[slot / W];
  const std::uint32_t lane = slot % W;
  return {{Real(block.x[lane]), Real(block.y[lane]), Real(block.z[lane])},
          Real(block.radius[lane])};
}

/// A node with up to W children. Bounds of absent children are empty, so that no ray meets them.
template <typename Store, int W>
struct alignas(64) WideNode {
  Store planes[3][2][W];     ///< lower and upper x of each child, then y, then z
  std::uint32_t child[W];    ///< see ChildRef
  std::uint8_t order[8][W];  ///< children far to near for rays of each octant (bit: axis is < 0)
};

template <typename Store, int W>
struct BvhView {
  const WideNode<Store, W>* nodes = nullptr;      ///< the root is the first
  const SphereBlock<Store, W>* blocks = nullptr;  ///< the first ones are in no node
  SlotLabels labels;
  std::uint32_t node_count = 0;
  std::uint32_t open_spheres = 0;  ///< in the first blocks, in input order
  std::uint32_t stack_size = 0;    ///< pending children that a ray can have
  Store extent = 0;                ///< largest coordinate of the tree's spheres, radii included
};

}  // namespace parray::trace
