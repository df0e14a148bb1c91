#include "common/trace/bvh/wide_bvh.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <span>
#include <utility>
#include <vector>

namespace parray::trace {
namespace {

/// Spheres this many times larger than the median one stay outside the tree.
constexpr double giant = 32;

/// Returns the approximate median, from a sample.
template <typename Store>
Store middling_radius(std::span<const BuildSphere<Store>> spheres) {
  constexpr std::size_t sample_size = 4095;
  std::vector<Store> radii;
  for (std::size_t i = 0; i < spheres.size(); i += spheres.size() / sample_size + 1) {
    radii.push_back(spheres[i].radius);
  }
  const auto middle = radii.begin() + static_cast<std::ptrdiff_t>(radii.size() / 2);
  std::nth_element(radii.begin(), middle, radii.end());
  return *middle;
}

/// Returns the largest coordinate of a box's corners.
template <typename Store>
Store extent_of(const Bounds<Store>& box) {
  const auto largest = [](const Vec3<Store>& v) {
    return std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)});
  };
  return std::max(largest(box.lo), largest(box.hi));
}

/// Returns the box enlarged by its spheres' part of the rounding (see WideBvh).
template <typename Store>
Bounds<Store> inflated(const Bounds<Store>& box) {
  const Store margin = Store(32) * RealTraits<Store>::unit_roundoff * extent_of(box);
  const Vec3<Store> grow{margin, margin, margin};
  return {box.lo - grow, box.hi + grow};
}

template <typename Store, int W>
void set_bounds(WideNode<Store, W>& node, int child, const Bounds<Store>& box) {
  const Vec3<Store> bounds[2] = {box.lo, box.hi};
  for (int side = 0; side < 2; ++side) {
    node.planes[0][side][child] = bounds[side].x;
    node.planes[1][side][child] = bounds[side].y;
    node.planes[2][side][child] = bounds[side].z;
  }
}

/// Sets the order of children, far to near along the diagonal of each octant.
template <typename Store, int W>
void set_order(WideNode<Store, W>& node, int children) {
  for (int octant = 0; octant < 8; ++octant) {
    Store nearness[W];
    std::uint8_t* order = node.order[octant];
    for (int k = 0; k < W; ++k) {
      order[k] = static_cast<std::uint8_t>(k);
      nearness[k] = 0;
      for (int axis = 0; axis < 3 && k < children; ++axis) {
        const Store middle = node.planes[axis][0][k] + node.planes[axis][1][k];
        nearness[k] += (octant >> axis & 1) != 0 ? middle : -middle;
      }
    }
    std::stable_sort(order, order + children,
                     [&](std::uint8_t a, std::uint8_t b) { return nearness[a] < nearness[b]; });
  }
}

/// Returns the ChildRef of a child that is written at the next place.
template <typename Store, typename Places>
std::uint32_t reference(const BinaryNode<Store>& child, const Places& next) {
  return child.left == 0 ? next.block | ChildRef::is_block : next.node;
}

}  // namespace

template <typename Store, int W>
WideBvh<Store, W>::WideBvh(Spheres spheres, bool tree, int threads)
    : index_bits_(static_cast<int>(std::bit_width(spheres.size() + 1))) {
  const bool of_one_block = spheres.size() <= W;
  build(spheres, tree && !of_one_block ? move_giants(spheres) : spheres.size(), threads);
}

template <typename Store, int W>
std::size_t WideBvh<Store, W>::move_giants(Spheres& spheres) {
  const std::span<BuildSphere<Store>> all(spheres.data(), spheres.size());
  const Store limit = static_cast<Store>(giant) * middling_radius<Store>(all);
  const auto is_giant = [limit](const auto& sphere) { return sphere.radius > limit; };
  const auto count = static_cast<std::size_t>(std::count_if(all.begin(), all.end(), is_giant));
  if (count > W) {
    return 0;
  }
  auto next = all.begin();  // place of the next one: they stay in input order
  for (std::size_t moved = 0; moved < count; ++moved, ++next) {
    std::iter_swap(next, std::find_if(next, all.end(), is_giant));
  }
  return count;
}

template <typename Store, int W>
BvhView<Store, W> WideBvh<Store, W>::view() const {
  return {nodes(), blocks(), labels(), node_count(), open_spheres(), stack_size(), extent_};
}

template <typename Store, int W>
void WideBvh<Store, W>::build(Spheres& spheres, std::size_t open, int threads) {
  open_spheres_ = static_cast<std::uint32_t>(open);
  const auto open_blocks = static_cast<std::uint32_t>((open + W - 1) / W);
  if (open == spheres.size()) {
    blocks_ = AlignedArray<SphereBlock<Store, W>>(std::max(open_blocks, 1U));
    labels_ = AlignedArray<std::uint32_t>(blocks_.size() * W);
    fill_block(0, nullptr, 0);  // even without spheres, slot 0 must be loadable
    fill_open_blocks(spheres);
    return;
  }
  const std::span<BuildSphere<Store>> in_tree(spheres.data() + open, spheres.size() - open);
  const Tree tree = build_binary_tree<Store>(in_tree, W, threads);
  extent_ = extent_of(tree.nodes[0].box);
  const Wide wide(tree, threads);
  emit(tree, wide, in_tree.data(), {1, open_blocks, 1}, threads);
  fill_open_blocks(spheres);
}

template <typename Store, int W>
void WideBvh<Store, W>::fill_open_blocks(const Spheres& spheres) {
  for (std::uint32_t begin = 0; begin < open_spheres_; begin += W) {
    fill_block(begin / W, spheres.data() + begin,
               std::min<std::uint32_t>(W, open_spheres_ - begin));
  }
}

template <typename Store, int W>
void WideBvh<Store, W>::fill_block(std::uint32_t index, const BuildSphere<Store>* spheres,
                                   std::uint32_t count) {
  constexpr Store none = std::numeric_limits<Store>::quiet_NaN();
  SphereBlock<Store, W>& block = blocks_[index];
  for (std::uint32_t lane = 0; lane < W; ++lane) {
    const bool present = lane < count;
    block.x[lane] = present ? spheres[lane].x : none;
    block.y[lane] = present ? spheres[lane].y : none;
    block.z[lane] = present ? spheres[lane].z : none;
    block.radius[lane] = present ? spheres[lane].radius : none;
    labels_[std::size_t{index} * W + lane] = present ? spheres[lane].index : index_mask();
  }
}

/// Counts the nodes and blocks that replace a binary node and the nodes below it.
template <typename Store, int W>
void WideBvh<Store, W>::count(const Tree& tree, const Wide& wide, std::uint32_t below,
                              Places& places) {
  if (tree.nodes[below].left == 0) {
    ++places.block;
    return;
  }
  ++places.node;
  const auto children = wide.children(below);
  for (int k = 0; k < children.count; ++k) {
    count(tree, wide, children.node[k], places);
  }
}

/// Writes all nodes and their blocks. The nodes below the root begin at `next`, one child of the
/// root after the other. The counts of the earlier children determine where a child begins, so the
/// children are written in parallel.
template <typename Store, int W>
void WideBvh<Store, W>::emit(const Tree& tree, const Wide& wide, const BuildSphere<Store>* spheres,
                             Places next, int threads) {
  const auto children = wide.children(0);
  Places places[W];
#pragma omp parallel for num_threads(threads) if (threads > 1) schedule(dynamic)
  for (int k = 0; k < children.count; ++k) {
    count(tree, wide, children.node[k], places[k]);
  }
  for (int k = 0; k < children.count; ++k) {
    const Places counted = places[k];
    places[k] = next;
    next.node += counted.node;
    next.block += counted.block;
  }
  blocks_ = AlignedArray<SphereBlock<Store, W>>(next.block);
  nodes_ = AlignedArray<WideNode<Store, W>>(next.node);
  labels_ = AlignedArray<std::uint32_t>(std::size_t{next.block} * W);
  set_children(nodes_[0], tree, children);
#pragma omp parallel for num_threads(threads) if (threads > 1) schedule(dynamic)
  for (int k = 0; k < children.count; ++k) {
    nodes_[0].child[k] = reference(tree.nodes[children.node[k]], places[k]);
    emit(tree, wide, spheres, children.node[k], 2, places[k]);
  }
  for (int k = 0; k < children.count; ++k) {
    depth_ = std::max(depth_, places[k].depth);
  }
}

/// Writes a binary node and the nodes below it, from `next` on.
template <typename Store, int W>
void WideBvh<Store, W>::emit(const Tree& tree, const Wide& wide, const BuildSphere<Store>* spheres,
                             std::uint32_t below, std::uint32_t level, Places& next) {
  const BinaryNode<Store>& here = tree.nodes[below];
  if (here.left == 0) {
    fill_block(next.block++, spheres + here.begin, here.end - here.begin);
    return;
  }
  next.depth = std::max(next.depth, level);
  WideNode<Store, W>& node = nodes_[next.node++];
  const auto children = wide.children(below);
  set_children(node, tree, children);
  for (int k = 0; k < children.count; ++k) {
    node.child[k] = reference(tree.nodes[children.node[k]], next);
    emit(tree, wide, spheres, children.node[k], level + 1, next);
  }
}

/// Fills a node except for the numbers of its children.
template <typename Store, int W>
void WideBvh<Store, W>::set_children(WideNode<Store, W>& node, const Tree& tree,
                                     const typename Wide::Children& children) {
  constexpr Store most = std::numeric_limits<Store>::max();
  for (int k = 0; k < W; ++k) {
    if (k < children.count) {
      set_bounds(node, k, inflated(tree.nodes[children.node[k]].box));
    } else {
      set_bounds(node, k, {{most, most, most}, {-most, -most, -most}});
      node.child[k] = ChildRef::is_end;  // no ray gets here
    }
  }
  set_order(node, children.count);
}

template class WideBvh<float, 4>;
template class WideBvh<float, 8>;
template class WideBvh<float, 16>;
template class WideBvh<double, 4>;
template class WideBvh<double, 8>;

}  // namespace parray::trace
