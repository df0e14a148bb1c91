#pragma once

#include <cstdint>

#include "common/trace/capsule.h"
#include "common/trace/sphere.h"

/// A tree of spheres or of capsules, in the form that traversal reads: plain tables, owned and
/// filled by WideBvh. Leaves are blocks of shapes. A shape's slot is its place in the tables: lane
/// k of block b is slot b * W + k.
///
/// `Store` is the type of stored shapes and boxes. `W`, the width of a node and of a block, is the
/// number of `Store` lanes of the instruction set. `Block` is the block of one kind of shape.
namespace parray::trace {

/// A block of up to W spheres. Lanes without a sphere hold NaN, so that no ray meets them.
template <typename Store, int W>
struct alignas(64) SphereBlock {
  Store x[W];
  Store y[W];
  Store z[W];
  Store radius[W];
};

/// A block of up to W capsules: see SphereBlock.
template <typename Store, int W>
struct alignas(64) CapsuleBlock {
  Store x[W];  ///< middles
  Store y[W];
  Store z[W];
  Store half_x[W];
  Store half_y[W];
  Store half_z[W];
  Store radius[W];
};

/// A child of a node in one word: the number of a node, or of a block of shapes if `is_block` is
/// set. `is_end` stands for no child: at the bottom of a stack, and in nodes with fewer than W.
struct ChildRef {
  static constexpr std::uint32_t is_block = 0x80000000;
  static constexpr std::uint32_t is_end = 0x40000000;
  static constexpr std::uint32_t number = 0x7FFFFFFF;
};

/// The labels of slots, one word each. The low bits hold the shape's number in the input. The bits
/// above hold a tag, which the owner of the tables may set.
struct SlotLabels {
  const std::uint32_t* at = nullptr;  ///< by slot
  std::uint32_t index_mask = 0;  ///< of the low bits; all are set in the label of an empty slot

  /// Returns the shape's number in the input, below index_mask; ties go to the lower number.
  [[nodiscard]] PARRAY_INLINE std::uint32_t index(std::uint32_t slot) const {
    return at[slot] & index_mask;
  }
};

/// Return the shape in a slot of a tree.
template <typename Real, typename Store, int W>
PARRAY_INLINE SphereShape<Real> shape_at(const SphereBlock<Store, W>* blocks, std::uint32_t slot) {
  const SphereBlock<Store, W>& block = blocks[slot / W];
  const std::uint32_t lane = slot % W;
  return {{Real(block.x[lane]), Real(block.y[lane]), Real(block.z[lane])},
          Real(block.radius[lane])};
}

template <typename Real, typename Store, int W>
PARRAY_INLINE CapsuleShape<Real> shape_at(const CapsuleBlock<Store, W>* blocks,
                                          std::uint32_t slot) {
  const CapsuleBlock<Store, W>& block = blocks[slot / W];
  const std::uint32_t lane = slot % W;
  return {{Real(block.x[lane]), Real(block.y[lane]), Real(block.z[lane])},
          {Real(block.half_x[lane]), Real(block.half_y[lane]), Real(block.half_z[lane])},
          Real(block.radius[lane])};
}

/// A node with up to W children. Bounds of absent children are empty, so that no ray meets them.
template <typename Store, int W>
struct alignas(64) WideNode {
  Store planes[3][2][W];   ///< lower and upper x of each child, then y, then z
  std::uint32_t child[W];  ///< see ChildRef
  /// Children from far to near, for rays of each octant (bit k: direction < 0 along axis k).
  std::uint8_t order[8][W];
};

/// The tables of a WideBvh.
template <typename Store, int W, template <typename, int> class Block = SphereBlock>
struct BvhView {
  const WideNode<Store, W>* nodes = nullptr;  ///< the root is the first
  const Block<Store, W>* blocks = nullptr;    ///< the first blocks belong to no node
  SlotLabels labels;
  std::uint32_t node_count = 0;  ///< 0: there is no tree
  /// Number of spheres outside the tree, which every ray tests. They are in the first blocks, in
  /// input order.
  std::uint32_t open_spheres = 0;
  std::uint32_t stack_size = 0;  ///< stack entries of a ray: see WideBvh::stack_size()
  /// Slots [first_slot, end_slot) are this tree's for paths, which number the slots of capsules
  /// after those of spheres. `labels` and `blocks` begin with first_slot.
  std::uint32_t first_slot = 0;
  std::uint32_t end_slot = 0;
  Store extent = 0;  ///< largest absolute coordinate of the tree's shapes, radii included
};

}  // namespace parray::trace
