#pragma once

#include <cstdint>
#include <limits>

#include "common/trace/bvh/beam_search.h"
#include "common/trace/bvh/bvh_view.h"
#include "common/trace/bvh/lane_loads.h"
#include "common/trace/bvh/nearest_crossings.h"
#include "common/trace/bvh/ray_columns.h"
#include "common/trace/bvh/ray_groups.h"
#include "common/trace/bvh/screen.h"

/// Finds the next surface of many rays. Each ray is tested against all children of a node, or all
/// spheres of a block, at once. The rays of a group advance in turns, one step each. So no step
/// waits for the result of the previous one (no mispredicted branch, no exposed cache miss). Source
/// for traversal by octant order and compaction instead of sorting: Fuetterling, Lojewski,
/// Pfreundt, Hamann, Ebert, "Accelerated single ray tracing for wide vector units", HPG 2017.
namespace parray::trace {

/// `L` are lanes of the real type, `B` lanes of the stored type. `Block` tells the kind of shape.
template <typename L, typename B, template <typename, int> class Block = SphereBlock>
class Traversal {
 public:
  using Real = typename L::Scalar;
  using Store = typename B::Scalar;
  static constexpr int width = B::count;
  using Space = TraversalSpace<Real, Store>;

  PARRAY_INLINE Traversal(const BvhView<Store, width, Block>& bvh, const RayColumns<Real>& rays,
                          Space& space)
      : bvh_(bvh),
        nodes_(bvh.nodes),
        blocks_(bvh.blocks),
        node_count_(bvh.node_count),
        open_spheres_(bvh.open_spheres),
        stack_size_(bvh.stack_size),
        first_slot_(is_spheres ? 0 : bvh.first_slot),
        end_slot_(bvh.end_slot),
        extent_(bvh.extent),
        rays_(rays),
        queries_(space.queries),
        nearest_(bvh.labels, first_slot_, space.queries),
        space_(space) {}

  /// Sets queries.t, .slot and .leaving for every ray, from the spheres. `InsideStack`: rays can be
  /// inside a shape. `Mixed`: the scene also has capsules, which find_nearer() then tries.
  template <bool InsideStack, bool Mixed = false>
  PARRAY_INLINE void find_all() {
    for (std::uint32_t i = 0; i < rays_.count; i += L::count) prepare(i);
    const bool beams = !Mixed && space_.beam >= width;
    const std::uint32_t done = beams ? BeamSearch<L, B>(bvh_, rays_, space_).find() : 0;
    for (std::uint32_t i = 0; node_count_ > 0 && i < rays_.count; i += B::count) {
      if (!beams || queries_.octant[i] != BeamSearch<L, B>::no_octant) prepare_boxes(i);
    }
    for (std::uint32_t first = 0; first < open_spheres_; first += bar_bits) {
      try_open_spheres<InsideStack>(first, done);
    }
    space_.beam = 0;
    find_in_tree<InsideStack, Mixed>();
  }

  /// Improves what find_all() of the spheres has found, from the capsules. `boxes_prepared`: the
  /// spheres are in a tree, too.
  template <bool InsideStack>
  PARRAY_INLINE void find_nearer(bool boxes_prepared) {
    for (std::uint32_t i = 0; !boxes_prepared && i < rays_.count; i += B::count) prepare_boxes(i);
    find_in_tree<InsideStack, true>();
  }

 private:
  static constexpr bool is_spheres = std::is_same_v<Block<Store, width>, SphereBlock<Store, width>>;
  /// True for spheres if paths have a wider type than the stored data.
  static constexpr bool screened = is_spheres && sizeof(Real) != sizeof(Store);
  static constexpr std::uint32_t group_size = Waiting::most;
  static constexpr std::uint32_t bar_bits = 32;
  static constexpr std::uint32_t all_lanes = (1U << width) - 1U;
  static constexpr std::uint32_t lanes_set = (1U << L::count) - 1U;
  static constexpr Real infinity = std::numeric_limits<Real>::infinity();
  static constexpr Store infinity_stored = std::numeric_limits<Store>::infinity();

  using Group = RayGroup<width>;

  /// Finds the nearest crossings that are exits, or entries into shapes of the tree.
  template <bool InsideStack, bool Mixed>
  PARRAY_INLINE void find_in_tree() {
    each_inside<L, InsideStack>(
        rays_, [&](std::uint32_t i) __attribute__((always_inline)) { find_exit<Mixed>(i); });
    for (std::uint32_t octant = 0; node_count_ > 0 && octant < 8; ++octant) {
      traverse_octant<InsideStack>(octant);
    }
  }

  PARRAY_INLINE void prepare(std::uint32_t i) {
    const Vec3<L> d = rays_.direction.template load<L>(i);
    (L(Real(1)) / dot(d, d)).store(&queries_.inverse_square[i]);
    L(infinity).store(&queries_.t[i]);
    typename L::Uint(no_shape).store(&queries_.slot[i]);
    typename L::Uint(0U).store(&queries_.leaving[i]);
  }

  /// Prepares rays i, i + 1, ... for the tests of boxes (Slab) and, if paths have a wider type than
  /// the stored data, of spheres (screen.h). The planes of boxes move outward by 32 roundoffs of
  /// the ray's origin.
  PARRAY_INLINE void prepare_boxes(std::uint32_t i) {
    const Vec3<B> o = stored_lanes<B>(rays_.origin, i);
    const Vec3<B> d = stored_lanes<B>(rays_.direction, i);
    const B reach = max_of(max_of(max_of(o.x, -o.x), max_of(o.y, -o.y)), max_of(o.z, -o.z));
    const B margin = B(Store(32) * RealTraits<Store>::unit_roundoff) * reach;
    const B steepest = Slab<B>::steepest(reach);
    const Slab<B> x(o.x, d.x, margin, steepest);
    const Slab<B> y(o.y, d.y, margin, steepest);
    const Slab<B> z(o.z, d.z, margin, steepest);
    const B sum = (o.x + o.y + o.z) + (d.x + d.y + d.z);
    // NOLINTNEXTLINE(misc-redundant-expression): a NaN is not
    const auto number = sum == sum;  // a NaN direction meets nothing, see enters_at: z comes last
    const B nowhere(infinity_stored);
    const B z_inverse = select(number, z.inverse, B(Store(0)));
    queries_.inverse.store(i, Vec3<B>{x.inverse, y.inverse, z_inverse});
    queries_.near_shift.store(i, Vec3<B>{x.near, y.near, select(number, z.near, nowhere)});
    queries_.far_shift.store(i, Vec3<B>{x.far, y.far, select(number, z.far, -nowhere)});
    if constexpr (screened) prepare_screen(queries_.screen, i, o, d, reach, extent_);
    using Uint = typename B::Uint;
    const auto bit = [](const auto& down, std::uint32_t value) {
      return select(down, Uint(value), Uint(0U));
    };
    (bit(x.down, 1) + bit(y.down, 2) + bit(z.down, 4)).store(&queries_.octant[i]);
  }

  template <typename T>
  PARRAY_INLINE Ray<T> ray(std::uint32_t i) const {
    return {vec_cast<T>(rays_.origin[i]), vec_cast<T>(rays_.direction[i]),
            T(queries_.inverse_square[i])};
  }

  PARRAY_INLINE auto shape(std::uint32_t slot) const {
    return shape_at<Real>(blocks_, slot - first_slot_);
  }

  /// Returns the parameter at which ray `i` leaves the shape in a slot.
  PARRAY_INLINE Real exit(std::uint32_t i, std::uint32_t slot) const {
    const Ray<Real> r = ray<Real>(i);
    if constexpr (is_spheres) {
      if (slot == rays_.surface[i]) return chord_from_surface(r, shape(slot), rays_.normal[i]);
    }
    return exit_distance(r, shape(slot));
  }

  /// Tests open spheres [first, first + bar_bits), one after the other, against lanes of rays from
  /// ray `begin` on.
  template <bool InsideStack>
  PARRAY_INLINE void try_open_spheres(std::uint32_t first, std::uint32_t begin) {
    const std::uint32_t left = open_spheres_ - first;
    const std::uint32_t count = left < bar_bits ? left : bar_bits;
    for (std::uint32_t i = 0; i < rays_.count; i += L::count) {
      const auto surface = L::Uint::load(&rays_.surface[i]);
      one_shifted_by(surface + typename L::Uint(0U - first)).store(&queries_.excluded[i]);
    }
    each_inside<L, InsideStack>(
        rays_, [&](std::uint32_t i) __attribute__((always_inline)) {
          queries_.excluded[i] = cannot_enter<InsideStack, bar_bits>(i, first);
        });
    for (std::uint32_t i = begin; i < rays_.count; i += L::count) {
      const Ray<L> rays(rays_.origin.template load<L>(i), rays_.direction.template load<L>(i),
                        L::load(&queries_.inverse_square[i]));
      const auto excluded = L::Uint::load(&queries_.excluded[i]);
      L nearest = L::load(&queries_.t[i]);
      auto slot = L::Uint::load(&queries_.slot[i]);
      for (std::uint32_t k = 0; k < count; ++k) {
        const SphereShape<Real> one = shape(first + k);
        const SphereShape<L> same{vec_cast<L>(one.center), L(one.radius)};
        const ClosestApproach<L> passage(rays, same);
        const auto allowed = equal(excluded & typename L::Uint(1U << k), typename L::Uint(0U));
        const auto met = passage.approaches() & allowed;
        if (!any(met)) {
          continue;  // without the square root, which is expensive
        }
        const L t = entry_distance(passage.foot, passage.depth_squared, rays.inverse_square);
        // Tests run in input order: an equal distance belongs to the earlier sphere.
        const auto better = met & (t < nearest);
        nearest = select(better, t, nearest);
        slot = select(better, typename L::Uint(first + k), slot);
      }
      nearest.store(&queries_.t[i]);
      slot.store(&queries_.slot[i]);
    }
  }

  /// Finds the nearest exit out of the tree's shapes that a path is inside of.
  template <bool Mixed>
  PARRAY_INLINE void find_exit(std::uint32_t i) {
    for (std::uint32_t link = rays_.inside[i]; link != InsideLists::none;
         link = space_.inside.next(link)) {
      const std::uint32_t slot = space_.inside.shape(link);
      if (Mixed && (slot < first_slot_ || slot >= end_slot_)) continue;
      const Real t = exit(i, slot);
      if (t < queries_.t[i] || (t == queries_.t[i] && nearest_.wins_tie(slot, queries_.slot[i]))) {
        queries_.t[i] = t;
        queries_.slot[i] = slot;
        queries_.leaving[i] = 1;
      }
    }
  }

  /// Returns which of `Count` slots from `first_slot` on a path cannot enter: the shape that it
  /// stands on, and the shapes that it is inside of (see inside_stack.h).
  template <bool InsideStack, std::uint32_t Count>
  PARRAY_INLINE std::uint32_t cannot_enter(std::uint32_t i, std::uint32_t first_slot) const {
    std::uint32_t lanes = bit_below<Count>(rays_.surface[i] - first_slot);
    if constexpr (InsideStack) {
      for (std::uint32_t link = rays_.inside[i]; link != InsideLists::none;
           link = space_.inside.next(link)) {
        lanes |= bit_below<Count>(space_.inside.shape(link) - first_slot);
      }
    }
    return lanes;
  }
  /// The shapes of a block that a ray may enter, and the passage of its line by spheres, kept
  /// between test_block() and take_nearest(). If the stored type is narrower, test_block() only
  /// screens a block of spheres, and take_nearest() computes the line.
  struct Passages {
    static constexpr int kept = is_spheres && !screened ? width / L::count : 1;
    L foot[kept];
    L depth_squared[kept];
    std::uint32_t candidates;  ///< as bits
    std::uint32_t first_slot;
  };

  /// Finds the shapes of a block that the ray enters at any distance. take_nearest() does the
  /// expensive part, the distances and their order, for the rays that need it.
  template <bool InsideStack>
  PARRAY_INLINE void test_block(std::uint32_t i, std::uint32_t index, Passages& out) const {
    const Block<Store, width>& block = blocks_[index];
    std::uint32_t met = 0;
    if constexpr (screened) {
      met = may_enter<B>(queries_.screen, i, block);
    } else if constexpr (!is_spheres) {
      const Ray<L> r = ray<L>(i);
      for (std::uint32_t k = 0; k < width; k += L::count) {
        const CapsuleShape<L> capsules = capsules_of<L>(block, k);
        met |= bits_of(CapsulePassage<L>(r, capsules).approaches()) << k;
      }
    } else {
      const Ray<L> r = ray<L>(i);
      for (std::uint32_t k = 0; k < width; k += L::count) {
        const ClosestApproach<L> passage(r, spheres_of<L>(block, k));
        out.foot[k / L::count] = passage.foot;
        out.depth_squared[k / L::count] = passage.depth_squared;
        met |= bits_of(passage.approaches()) << k;
      }
    }
    out.first_slot = first_slot_ + index * width;
    out.candidates = met & ~cannot_enter<InsideStack, width>(i, out.first_slot);
  }

  /// Improves the ray's nearest crossing and returns it in every lane.
  PARRAY_INLINE L take_nearest(std::uint32_t i, const Passages& passages) {
    if constexpr (screened) {
      return take_nearest_screened(i, passages);
    } else if constexpr (!is_spheres) {
      return take_nearest_capsule(i, passages);
    }
    L nearest(queries_.t[i]);
    const L inverse_square(queries_.inverse_square[i]);
    for (std::uint32_t k = 0; k < width; k += L::count) {
      const L t = entry_distance(passages.foot[k / L::count], passages.depth_squared[k / L::count],
                                 inverse_square);
      const std::uint32_t first = passages.first_slot + k;
      nearest = nearest_.take(i, t, passages.candidates >> k, nearest,
                              [=](std::uint32_t lane) { return first + lane; });
    }
    return nearest;
  }

  /// Does the same as take_nearest() for capsules.
  PARRAY_INLINE L take_nearest_capsule(std::uint32_t i, const Passages& passages) {
    const Block<Store, width>& block = blocks_[(passages.first_slot - first_slot_) / width];
    const Ray<L> r = ray<L>(i);
    L nearest(queries_.t[i]);
    for (std::uint32_t k = 0; k < width; k += L::count) {
      const CapsuleShape<L> capsules = capsules_of<L>(block, k);
      const L t = CapsulePassage<L>(r, capsules).crossing(L(Real(0)) > L(Real(0))).t;
      const std::uint32_t first = passages.first_slot + k;
      nearest = nearest_.take(i, t, passages.candidates >> k & lanes_set, nearest,
                              [=](std::uint32_t lane) { return first + lane; });
    }
    return nearest;
  }

  /// Does the same as take_nearest() if test_block() only screened the block: computes the exact
  /// passages of the candidates, packed into lanes.
  PARRAY_INLINE L take_nearest_screened(std::uint32_t i, const Passages& passages) {
    Candidates<Store>& few = space_.candidates;
    const SphereBlock<Store, width>& block = blocks_[passages.first_slot / width];
    const std::uint32_t set = passages.candidates;
    compress_store(few.x, set, B::load(block.x));
    compress_store(few.y, set, B::load(block.y));
    compress_store(few.z, set, B::load(block.z));
    compress_store(few.radius, set, B::load(block.radius));
    compress_store(few.slot, set, counting_from<typename B::Uint>(passages.first_slot));
    const auto count = static_cast<std::uint32_t>(__builtin_popcount(set));
    const Ray<L> r = ray<L>(i);
    L nearest(queries_.t[i]);
    for (std::uint32_t k = 0; k < count; k += L::count) {
      const ClosestApproach<L> passage(r, spheres_of<L>(few, k));
      const std::uint32_t present = count - k < L::count ? (1U << (count - k)) - 1 : all_lanes;
      const L t = entry_distance(passage.foot, passage.depth_squared, r.inverse_square);
      const std::uint32_t* const slots = few.slot + k;
      nearest = nearest_.take(i, t, bits_of(passage.approaches()) & present, nearest,
                              [=](std::uint32_t lane) { return slots[lane]; });
    }
    return nearest;
  }

  /// Moves all rays of an octant through the tree, in groups.
  template <bool InsideStack>
  PARRAY_INLINE void traverse_octant(std::uint32_t octant) {
    std::uint32_t* const numbers = space_.queries.numbers.at;
    std::uint32_t count = 0;
    for (std::uint32_t i = 0; i < rays_.count; i += B::count) {
      const auto mine = equal(B::Uint::load(&queries_.octant[i]), typename B::Uint(octant));
      const std::uint32_t left = rays_.count - i;
      const std::uint32_t present = left >= width ? all_lanes : (1U << left) - 1U;
      const std::uint32_t set = bits_of(mine) & present;
      compress_store(numbers + count, set, counting_from<typename B::Uint>(i));
      count += static_cast<std::uint32_t>(__builtin_popcount(set));
    }
    const std::uint32_t most = Space::stack_entries / stack_size_;
    const std::uint32_t size = most < group_size ? most : group_size;
    for (std::uint32_t begin = 0; begin < count; begin += size) {
      const std::uint32_t left = count - begin;
      traverse<InsideStack>({numbers + begin, left < size ? left : size, octant});
    }
  }

  template <bool InsideStack>
  void traverse(const Group& group) {
    Traversal here = *this;  // copies without a visible address
    const Group same = group;
    here.template traverse_group<InsideStack>(same);
  }

  template <bool InsideStack>
  PARRAY_INLINE void traverse_group(const Group group) {
    Waiting nodes[2];
    Waiting blocks[2];
    Passages passages[group_size];
    std::uint32_t top[group_size];  // places of each ray's last child in the stacks of the space
    enter_root(group, top);
    for (std::uint32_t k = 0; k < group.count; ++k) wait_for_next(k, top[k], nodes[0], blocks[0]);
    for (int now = 0; nodes[now].count + blocks[now].count > 0; now ^= 1) {
      nodes[now ^ 1].count = 0;
      blocks[now ^ 1].count = 0;
      for (std::uint32_t n = 0; n < nodes[now].count; ++n) {
        const std::uint32_t k = nodes[now].ray[n];
        top[k] = step_node(group, group.ray[k], nodes_[nodes[now].child[n]], top[k]);
      }
      for (std::uint32_t n = 0; n < nodes[now].count; ++n) {
        const std::uint32_t k = nodes[now].ray[n];
        wait_for_next(k, top[k], nodes[now ^ 1], blocks[now]);
      }
      Waiting entering;  // rays of `blocks` that enter a shape
      Waiting passing;   // the others
      for (std::uint32_t n = 0; n < blocks[now].count; ++n) {
        const std::uint32_t k = blocks[now].ray[n];
        test_block<InsideStack>(group.ray[k], blocks[now].child[n], passages[k]);
        const std::uint32_t enters = passages[k].candidates != 0 ? 1 : 0;
        entering.add(k, 0, enters);
        passing.add(k, 0, enters ^ 1U);
      }
      for (std::uint32_t n = 0; n < passing.count; ++n) {
        const std::uint32_t k = passing.ray[n];
        --top[k];
        wait_for_next(k, top[k], nodes[now ^ 1], blocks[now ^ 1]);
      }
      for (std::uint32_t n = 0; n < entering.count; ++n) {
        const std::uint32_t k = entering.ray[n];
        const L nearest = take_nearest(group.ray[k], passages[k]);
        top[k] = drop_farther(bound_of<B>(nearest), k * stack_size_, top[k]);
      }
      for (std::uint32_t n = 0; n < entering.count; ++n) {
        const std::uint32_t k = entering.ray[n];
        wait_for_next(k, top[k], nodes[now ^ 1], blocks[now ^ 1]);
      }
    }
  }

  /// Queues a ray for the child on top of its stack, if there is one.
  PARRAY_INLINE void wait_for_next(std::uint32_t k, std::uint32_t top, Waiting& nodes,
                                   Waiting& blocks) const {
    const std::uint32_t child = space_.stack_child[top];
    const std::uint32_t number = child & ChildRef::number;
    // Numbers instead of comparisons: compilers would turn comparisons into unpredictable branches.
    nodes.add(k, number, (child - ChildRef::is_end) >> 31 & ~child >> 31);
    blocks.add(k, number, child >> 31);
  }

  /// Returns where ray `i` enters boxes, from their planes on its near side. A NaN (of an absent
  /// plane) does not constrain the result: see max_of.
  PARRAY_INLINE B enters_at(const Vec3<B>& planes, std::uint32_t i) const {
    const B x = multiply_add(planes.x, B(queries_.inverse.x[i]), B(queries_.near_shift.x[i]));
    const B y = multiply_add(planes.y, B(queries_.inverse.y[i]), B(queries_.near_shift.y[i]));
    const B z = multiply_add(planes.z, B(queries_.inverse.z[i]), B(queries_.near_shift.z[i]));
    return max_of(max_of(x, y), max_of(z, B(Store(0))));
  }

  /// Returns where ray `i` leaves boxes, from their planes on its far side, or its nearest crossing
  /// if that is closer.
  PARRAY_INLINE B leaves_at(const Vec3<B>& planes, std::uint32_t i) const {
    const B x = multiply_add(planes.x, B(queries_.inverse.x[i]), B(queries_.far_shift.x[i]));
    const B y = multiply_add(planes.y, B(queries_.inverse.y[i]), B(queries_.far_shift.y[i]));
    const B z = multiply_add(planes.z, B(queries_.inverse.z[i]), B(queries_.far_shift.z[i]));
    return min_of(min_of(x, y), min_of(z, bound_of<B>(L(queries_.t[i]))));
  }

  /// Makes the first step of all rays of a group: from the root, with boxes that stay in registers.
  PARRAY_INLINE void enter_root(const Group& group, std::uint32_t* top) const {
    const WideNode<Store, width>& root = nodes_[0];
    const auto order = B::load_order(root.order[group.octant]);
    const auto ordered = [&](const Vec3<B>& planes) {
      return Vec3<B>{permute(planes.x, order), permute(planes.y, order), permute(planes.z, order)};
    };
    const Vec3<B> near = ordered(planes_of<B>(group, root, 0));
    const Vec3<B> far = ordered(planes_of<B>(group, root, 1));
    const auto children = permute(B::Uint::load(root.child), order);
    for (std::uint32_t k = 0; k < group.count; ++k) {
      const std::uint32_t bottom = k * stack_size_;
      space_.stack_t[bottom] = -infinity_stored;  // never removed from the stack
      space_.stack_child[bottom] = ChildRef::is_end;
      const B enters = enters_at(near, group.ray[k]);
      const std::uint32_t met = bits_of(enters <= leaves_at(far, group.ray[k]));
      compress_store(space_.stack_t + bottom + 1, met, enters);
      compress_store(space_.stack_child + bottom + 1, met, children);
      top[k] = bottom + static_cast<std::uint32_t>(__builtin_popcount(met));
    }
  }

  /// Replaces the node on top of a stack by those of its children that ray `i` meets before its
  /// nearest crossing. Returns the new top.
  PARRAY_INLINE std::uint32_t step_node(const Group& group, std::uint32_t i,
                                        const WideNode<Store, width>& node,
                                        std::uint32_t top) const {
    const B near = enters_at(planes_of<B>(group, node, 0), i);
    const B far = leaves_at(planes_of<B>(group, node, 1), i);
    const auto order = B::load_order(node.order[group.octant]);
    const B ordered = permute(near, order);
    const std::uint32_t met = bits_of(ordered <= permute(far, order));
    const auto children = permute(B::Uint::load(node.child), order);
    compress_store(space_.stack_t + top, met, ordered);
    compress_store(space_.stack_child + top, met, children);
    return top + static_cast<std::uint32_t>(__builtin_popcount(met)) - 1;
  }

  /// Removes the child on top of the stack and all that begin beyond the nearest crossing. Returns
  /// the new top.
  PARRAY_INLINE std::uint32_t drop_farther(const B& bound, std::uint32_t bottom,
                                           std::uint32_t top) const {
    std::uint32_t kept = bottom;
    std::uint32_t k = bottom;
    do {
      const B child_t = B::load(space_.stack_t + k);
      const auto child = B::Uint::load(space_.stack_child + k);
      const std::uint32_t left = top - k;
      const std::uint32_t present = left >= width ? all_lanes : (1U << left) - 1U;
      const std::uint32_t keep = bits_of(child_t <= bound) & present;
      compress_store(space_.stack_t + kept, keep, child_t);
      compress_store(space_.stack_child + kept, keep, child);
      kept += static_cast<std::uint32_t>(__builtin_popcount(keep));
      k += width;
    } while (k < top);
    return kept - 1;
  }

  const BvhView<Store, width, Block>& bvh_;
  // Copies, so that they stay in registers even if something is stored.
  const WideNode<Store, width>* nodes_;
  const Block<Store, width>* blocks_;
  std::uint32_t node_count_;
  std::uint32_t open_spheres_;
  std::uint32_t stack_size_;
  std::uint32_t first_slot_;
  std::uint32_t end_slot_;
  Store extent_;
  const RayColumns<Real>& rays_;
  Queries<Real, Store>& queries_;
  NearestCrossings<L, Store> nearest_;
  Space& space_;
};

}  // namespace parray::trace
