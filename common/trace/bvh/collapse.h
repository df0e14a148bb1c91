#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>

#include "common/trace/bvh/sah_builder.h"

namespace parray::trace {

/// How a binary tree becomes one whose nodes have up to W children: the nodes to keep, chosen so
/// that the sum of their areas and their leaves', what a random ray is expected to step on, is the
/// least that this binary tree allows. A function of the tree alone, whatever the threads.
///
/// Source: Ylitie, Karras, Laine, "Efficient incoherent ray traversal on GPUs through compressed
/// wide BVHs", HPG 2017, section 3.1: C(n, i), the least cost of what is below n as at most i
/// trees, by dynamic programming.
template <typename Store, int W>
class Collapse {
 public:
  /// `tree` stays where it is.
  Collapse(const BinaryTree<Store>& tree, int threads);

  struct Children {
    std::uint32_t node[W];  ///< of the binary tree
    int count = 0;
  };
  /// Of the wide node that node `root` becomes; a leaf, the root of a small tree, is its only
  /// child.
  [[nodiscard]] Children children(std::uint32_t root) const;

 private:
  /// [i - 1]: the least cost as at most i trees.
  using Costs = std::array<Store, W>;
  /// [i - 1], i = 2 .. W - 1: how many of i trees the left side makes; 0: the node is one of its
  /// own. [0]: of W, below the node itself.
  using Shares = std::array<std::uint8_t, W>;

  Costs solve(std::uint32_t node, std::uint32_t task_levels);
  void add(std::uint32_t node, std::size_t trees, Children& to) const;

  const BinaryTree<Store>& tree_;
  std::unique_ptr<Shares[]> shares_;  ///< by node; those of leaves are never touched
};

}  // namespace parray::trace
