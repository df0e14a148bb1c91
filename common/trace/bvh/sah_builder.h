#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>

#include "common/math/vec.h"

namespace parray::trace {

/// A sphere in the form that the builder reorders. `Store`: float or double.
template <typename Store>
struct BuildSphere {
  Store x, y, z;
  Store radius;
  std::uint32_t index;  ///< index in the input
};

/// A capsule in the form that the builder reorders.
template <typename Store>
struct BuildCapsule {
  Store x, y, z;  ///< middle
  Store radius;
  Vec3<Store> half;     ///< from the middle to one end
  std::uint32_t index;  ///< index in the input
};

/// A box: all points from `lo` to `hi` on each axis.
template <typename Store>
struct Bounds {
  Vec3<Store> lo;
  Vec3<Store> hi;
};

/// A node of a binary tree over a range of shapes; leaves hold at most `leaf_size`.
template <typename Store>
struct BinaryNode {
  Bounds<Store> box;    ///< box of the shapes, not inflated
  std::uint32_t begin;  ///< the shapes below it: [begin, end) of the reordered shapes
  std::uint32_t end;
  std::uint32_t left;   ///< number of the first child's node; 0: a leaf
  std::uint32_t right;  ///< number of the second child's node; 0: a leaf
};

/// A binary tree; the root is node 0. Not every node of the array is used.
template <typename Store>
struct BinaryTree {
  std::unique_ptr<BinaryNode<Store>[]> nodes;
  std::size_t capacity = 0;  ///< of `nodes`
};

/// The most nodes from the root of a tree to a leaf, both included.
inline constexpr std::uint32_t max_tree_depth = 64;

/// Builds a tree top-down by the surface area heuristic with 16 bins per axis. Ranges of more than
/// 8192 shapes are cut across their longest axis only. The cost of a range is the area of its box
/// times the number of blocks of `leaf_size` shapes that it fills. Takes 1 to 2^30 shapes and
/// reorders them. Uses `threads` threads; the tree does not depend on their number. Source: Wald,
/// "On fast construction of SAH-based bounding volume hierarchies", 2007.
template <typename Store, template <typename> class Item>
BinaryTree<Store> build_binary_tree(std::span<Item<Store>> shapes, std::uint32_t leaf_size,
                                    int threads);

}  // namespace parray::trace
