#include "common/trace/bvh/wide_bvh.h"

#include <algorithm>
#include <bit>
#include <limits>
#include <span>
#include <vector>

#include "common/math/largest_component.h"
#include "common/trace/bvh/collapse.h"

namespace parray::trace {
namespace {

/// Spheres this many times larger than the median one stay outside the tree.
constexpr double giant = 32;

/// Returns the approximate median, from a sample.
template <typename Store, template <typename> class Item>
Store middling_radius(std::span<const Item<Store>> spheres) {
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
  return std::max(largest_component(box.lo), largest_component(box.hi));
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

template <typename Store, int W>
void set_lane(SphereBlock<Store, W>& block, std::uint32_t lane, const BuildSphere<Store>& sphere) {
  block.x[lane] = sphere.x;
  block.y[lane] = sphere.y;
  block.z[lane] = sphere.z;
  block.radius[lane] = sphere.radius;
}
template <typename Store, int W>
void set_lane(CapsuleBlock<Store, W>& block, std::uint32_t lane,
              const BuildCapsule<Store>& capsule) {
  block.x[lane] = capsule.x;
  block.y[lane] = capsule.y;
  block.z[lane] = capsule.z;
  block.half_x[lane] = capsule.half.x;
  block.half_y[lane] = capsule.half.y;
  block.half_z[lane] = capsule.half.z;
  block.radius[lane] = capsule.radius;
}

/// Returns the ChildRef of a child that is written at the next place.
template <typename Store, typename Places>
std::uint32_t reference(const BinaryNode<Store>& child, const Places& next) {
  return child.left == 0 ? next.block | ChildRef::is_block : next.node;
}

}  // namespace

/// Fills the tables of a WideBvh from its shapes, which it reorders.
template <typename Store, int W, template <typename, int> class Block>
class WideBvh<Store, W, Block>::Builder {
 public:
  Builder(WideBvh& bvh, Items& items, int threads) : bvh_(bvh), items_(items), threads_(threads) {}

  void build(bool tree) {
    const std::size_t open = open_shapes(tree);
    bvh_.open_spheres_ = static_cast<std::uint32_t>(open);
    const auto open_blocks = static_cast<std::uint32_t>((open + W - 1) / W);
    if (open == items_.size()) {
      bvh_.blocks_ = AlignedArray<Block<Store, W>>(std::max(open_blocks, 1U));
      bvh_.labels_ = AlignedArray<std::uint32_t>(bvh_.blocks_.size() * W);
      fill_block(0, nullptr, 0);  // even without shapes, slot 0 must be loadable
    } else {
      const std::span<Item> in_tree(items_.data() + open, items_.size() - open);
      const Tree binary = build_binary_tree<Store>(in_tree, W, threads_);
      bvh_.extent_ = extent_of(binary.nodes[0].box);
      const Wide wide(binary, threads_);
      emit(binary, wide, in_tree.data(), {1, open_blocks, 1});
    }
    for (std::uint32_t begin = 0; begin < open; begin += W) {
      fill_block(begin / W, items_.data() + begin,
                 std::min<std::uint32_t>(W, bvh_.open_spheres_ - begin));
    }
  }

 private:
  using Tree = BinaryTree<Store>;
  using Wide = Collapse<Store, W>;
  /// The next node and block to write, and the most levels written so far.
  struct Places {
    std::uint32_t node = 0;
    std::uint32_t block = 0;
    std::uint32_t depth = 0;
  };

  /// Moves the shapes that stay outside the tree to the front and returns their number.
  std::size_t open_shapes(bool tree) {
    if constexpr (std::is_same_v<Block<Store, W>, CapsuleBlock<Store, W>>) return 0;
    if (!tree || items_.size() <= W) return items_.size();
    const std::span<Item> all(items_.data(), items_.size());
    const Store limit =
        static_cast<Store>(giant) * middling_radius<Store>(std::span<const Item>(all));
    const auto is_giant = [limit](const auto& sphere) { return sphere.radius > limit; };
    const auto count = static_cast<std::size_t>(std::count_if(all.begin(), all.end(), is_giant));
    if (count > W) return 0;
    auto next = all.begin();  // place of the next one: they stay in input order
    for (std::size_t moved = 0; moved < count; ++moved, ++next) {
      std::iter_swap(next, std::find_if(next, all.end(), is_giant));
    }
    return count;
  }

  void fill_block(std::uint32_t index, const Item* items, std::uint32_t count) {
    constexpr Store nan = std::numeric_limits<Store>::quiet_NaN();
    Item none{};
    none.x = none.y = none.z = none.radius = nan;
    for (std::uint32_t lane = 0; lane < W; ++lane) {
      const bool present = lane < count;
      set_lane(bvh_.blocks_[index], lane, present ? items[lane] : none);
      bvh_.labels_[std::size_t{index} * W + lane] = present ? items[lane].index : bvh_.index_mask();
    }
  }

  /// Counts the nodes and blocks that replace a binary node and the nodes below it.
  static void count(const Tree& tree, const Wide& wide, std::uint32_t below, Places& places) {
    if (tree.nodes[below].left == 0) {
      ++places.block;
      return;
    }
    ++places.node;
    const auto children = wide.children(below);
    for (int k = 0; k < children.count; ++k) count(tree, wide, children.node[k], places);
  }

  /// Writes all nodes and their blocks. The nodes below the root begin at `next`, one child of the
  /// root after the other. The counts of the earlier children determine where a child begins, so
  /// the children are written in parallel.
  void emit(const Tree& tree, const Wide& wide, const Item* items, Places next) {
    const auto children = wide.children(0);
    Places places[W];
#pragma omp parallel for num_threads(threads_) if (threads_ > 1) schedule(dynamic)
    for (int k = 0; k < children.count; ++k) count(tree, wide, children.node[k], places[k]);
    for (int k = 0; k < children.count; ++k) {
      const Places counted = places[k];
      places[k] = next;
      next.node += counted.node;
      next.block += counted.block;
    }
    bvh_.blocks_ = AlignedArray<Block<Store, W>>(next.block);
    bvh_.nodes_ = AlignedArray<WideNode<Store, W>>(next.node);
    bvh_.labels_ = AlignedArray<std::uint32_t>(std::size_t{next.block} * W);
    set_children(bvh_.nodes_[0], tree, children);
#pragma omp parallel for num_threads(threads_) if (threads_ > 1) schedule(dynamic)
    for (int k = 0; k < children.count; ++k) {
      bvh_.nodes_[0].child[k] = reference(tree.nodes[children.node[k]], places[k]);
      emit(tree, wide, items, children.node[k], 2, places[k]);
    }
    for (int k = 0; k < children.count; ++k) bvh_.depth_ = std::max(bvh_.depth_, places[k].depth);
  }

  /// Writes a binary node and the nodes below it, from `next` on.
  void emit(const Tree& tree, const Wide& wide, const Item* items, std::uint32_t below,
            std::uint32_t level, Places& next) {
    const BinaryNode<Store>& here = tree.nodes[below];
    if (here.left == 0) {
      fill_block(next.block++, items + here.begin, here.end - here.begin);
      return;
    }
    next.depth = std::max(next.depth, level);
    WideNode<Store, W>& node = bvh_.nodes_[next.node++];
    const auto children = wide.children(below);
    set_children(node, tree, children);
    for (int k = 0; k < children.count; ++k) {
      node.child[k] = reference(tree.nodes[children.node[k]], next);
      emit(tree, wide, items, children.node[k], level + 1, next);
    }
  }

  /// Fills a node except for the numbers of its children.
  static void set_children(WideNode<Store, W>& node, const Tree& tree,
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

  WideBvh& bvh_;
  Items& items_;
  int threads_;
};

template <typename Store, int W, template <typename, int> class Block>
WideBvh<Store, W, Block>::WideBvh(Items items, bool tree, int threads)
    : index_bits_(static_cast<int>(std::bit_width(items.size() + 1))) {
  Builder(*this, items, threads).build(tree);
}

template <typename Store, int W, template <typename, int> class Block>
BvhView<Store, W, Block> WideBvh<Store, W, Block>::view() const {
  return {nodes(),      blocks(), labels(),     node_count(), open_spheres(),
          stack_size(), 0,        slot_count(), extent_};
}

template class WideBvh<float, 4>;
template class WideBvh<float, 8>;
template class WideBvh<float, 16>;
template class WideBvh<double, 4>;
template class WideBvh<double, 8>;
template class WideBvh<float, 4, CapsuleBlock>;
template class WideBvh<float, 8, CapsuleBlock>;
template class WideBvh<float, 16, CapsuleBlock>;
template class WideBvh<double, 4, CapsuleBlock>;
template class WideBvh<double, 8, CapsuleBlock>;

}  // namespace parray::trace
