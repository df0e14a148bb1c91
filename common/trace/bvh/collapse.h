#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>

#include "common/trace/bvh/sah_builder.h"

namespace parray::trace {

/// Turns a binary tree into a tree of nodes with up to W children. It chooses the nodes to keep so
/// that the sum of the surface areas of the kept nodes and of their leaves is the least that this
/// binary tree allows. The expected work of a random ray is proportional to that sum. The result
/// does not depend on the number of threads.
///
/// Source: Ylitie, Karras, Laine, "Efficient incoherent ray traversal on GPUs through compressed
/// wide BVHs", HPG 2017, section 3.1: C(n, i), the least cost of the part below n as at most i
/// trees, by dynamic programming.
template <typename Store, int W>
class Collapse {
 public:
  /// `tree` must stay in place.
  Collapse(const BinaryTree<Store>& tree, int threads);

  struct Children {
    std::uint32_t node[W];  ///< node of the binary tree
    int count = 0;
  };
  /// Returns the children of the wide node that replaces node `root`. If the root of a small tree
  /// is a leaf, it is its own only child.
  [[nodiscard]] Children children(std::uint32_t root) const;

 private:
  /// [i - 1]: the least cost with at most i trees.
  using Costs = std::array<Store, W>;
  /// [i - 1], i = 2 .. W - 1: the number of i trees that the left side makes; 0: the node is itself
  /// one tree. [0]: the same for W trees below the node.
  using Shares = std::array<std::uint8_t, W>;

  Costs solve(std::uint32_t node, std::uint32_t task_levels);
  void add(std::uint32_t node, std::size_t trees, Children& to) const;

  const BinaryTree<Store>& tree_;
  std::unique_ptr<Shares[]> shares_;  ///< by node; entries of leaves are never touched
};

}  // namespace parray::trace
