#include "common/trace/bvh/collapse.h"

#include <limits>

namespace parray::trace {
namespace {

/// Number of tree levels at which the left sides are tasks of their own.
constexpr std::uint32_t task_levels = 8;

template <typename Store>
Store half_area(const Bounds<Store>& box) {
  const Vec3<Store> d = box.hi - box.lo;
  return d.x * d.y + d.y * d.z + d.z * d.x;
}

}  // namespace

template <typename Store, int W>
Collapse<Store, W>::Collapse(const BinaryTree<Store>& tree, int threads)
    : tree_(tree), shares_(std::make_unique_for_overwrite<Shares[]>(tree.capacity)) {
#pragma omp parallel num_threads(threads) if (threads > 1)
#pragma omp single
  solve(0, threads > 1 ? task_levels : 0);
}

template <typename Store, int W>
typename Collapse<Store, W>::Costs Collapse<Store, W>::solve(std::uint32_t node,
                                                             std::uint32_t levels) {
  const BinaryNode<Store>& here = tree_.nodes[node];
  const Store area = half_area(here.box);
  Costs costs;
  if (here.left == 0) {
    costs.fill(area);
    return costs;
  }
  Costs left;
  if (levels > 0) {
#pragma omp task default(none) shared(left) firstprivate(here, levels)
    left = solve(here.left, levels - 1);
  } else {
    left = solve(here.left, 0);
  }
  const Costs right = solve(here.right, levels > 0 ? levels - 1 : 0);
  if (levels > 0) {
#pragma omp taskwait
  }
  costs.fill(std::numeric_limits<Store>::infinity());
  Shares& shares = shares_[node];
  shares.fill(1);  // for areas that overflow
  for (std::size_t k = 1; k < W; ++k) {
    for (std::size_t i = k + 1; i <= W; ++i) {
      const Store cost = left[k - 1] + right[i - k - 1];
      const bool better = cost < costs[i - 1];
      costs[i - 1] = better ? cost : costs[i - 1];
      shares[i - 1] = better ? static_cast<std::uint8_t>(k) : shares[i - 1];
    }
  }
  shares[0] = shares[W - 1];
  costs[0] = area + costs[W - 1];
  for (std::size_t i = 2; i <= W; ++i) {
    if (costs[0] < costs[i - 1]) {
      costs[i - 1] = costs[0];
      shares[i - 1] = 0;
    }
  }
  return costs;
}

template <typename Store, int W>
typename Collapse<Store, W>::Children Collapse<Store, W>::children(std::uint32_t root) const {
  Children found;
  const BinaryNode<Store>& node = tree_.nodes[root];
  if (node.left == 0) {
    add(root, 1, found);
    return found;
  }
  const std::size_t left = shares_[root][0];
  add(node.left, left, found);
  add(node.right, W - left, found);
  return found;
}

template <typename Store, int W>
void Collapse<Store, W>::add(std::uint32_t node, std::size_t trees, Children& to) const {
  const BinaryNode<Store>& here = tree_.nodes[node];
  const std::size_t left = here.left == 0 || trees == 1 ? 0 : shares_[node][trees - 1];
  if (left == 0) {
    to.node[to.count++] = node;
    return;
  }
  add(here.left, left, to);
  add(here.right, trees - left, to);
}

template class Collapse<float, 4>;
template class Collapse<float, 8>;
template class Collapse<float, 16>;
template class Collapse<double, 4>;
template class Collapse<double, 8>;

}  // namespace parray::trace
