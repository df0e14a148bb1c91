#pragma once

#include <cstdint>
#include <limits>

#include "common/trace/paths.h"
#include "common/trace/sphere.h"

/// Finding the next surface of many rays. Each ray is tested against all children of a node, or all
/// spheres of a block, at once; and the rays of a group advance in turns, one step each, so that no
/// step waits for the outcome of the one before (no mispredicted branch, no cache miss in sight).
/// Source for traversal by octant order and compaction instead of sorting: Fuetterling, Lojewski,
/// Pfreundt, Hamann, Ebert, "Accelerated single ray tracing for wide vector units", HPG 2017.
namespace parray {

/// `L` are lanes of the real type, `B` lanes of the stored one.
template <typename L, typename B>
class Stream {
 public:
  using Real = typename L::Scalar;
  using Store = typename B::Scalar;
  static constexpr int width = B::count;
  using SceneTables = KernelScene<Real, Store, width>;
  using Space = Workspace<Real, Store>;

  PARRAY_INLINE Stream(const SceneTables& scene, Space& space)
      : scene_(scene), paths_(space.paths), queries_(space.queries), space_(space) {}

  /// Sets queries.t, .slot and .leaving for every path. `Sides`: paths can be inside something.
  template <bool Sides>
  PARRAY_INLINE void find_all() {
    for (std::uint32_t i = 0; i < paths_.count; i += L::count) {
      prepare(i);
    }
    for (std::uint32_t i = 0; scene_.node_count > 0 && i < paths_.count; i += B::count) {
      prepare_boxes(i);
    }
    for (std::uint32_t first = 0; first < scene_.open_spheres; first += bar_bits) {
      try_open_spheres<Sides>(first);
    }
    if constexpr (Sides) {
      for (std::uint32_t i = 0; i < paths_.count; ++i) {
        find_exit(i);
      }
    }
    if (scene_.node_count > 0) {
      const std::uint32_t most = Space::stack_entries / scene_.stack_size;
      const std::uint32_t group = most < group_size ? most : group_size;
      for (std::uint32_t begin = 0; begin < paths_.count; begin += group) {
        const std::uint32_t end = begin + group;
        traverse<Sides>(begin, end < paths_.count ? end : paths_.count);
      }
    }
  }

 private:
  static constexpr std::uint32_t group_size = 64;
  static constexpr std::uint32_t bar_bits = 32;
  static constexpr Real infinity = std::numeric_limits<Real>::infinity();

  /// Ray numbers of a group that wait for a step of one kind.
  struct Waiting {
    std::uint32_t ray[group_size];
    std::uint32_t count = 0;
  };

  PARRAY_INLINE void prepare(std::uint32_t i) {
    const Vec3<L> d = paths_.direction.template load<L>(i);
    (L(Real(1)) / dot(d, d)).store(&queries_.inverse_square[i]);
    L(infinity).store(&queries_.t[i]);
    typename L::Uint(no_sphere).store(&queries_.slot[i]);
    typename L::Uint(0U).store(&queries_.leaving[i]);
  }

  /// The ray's share of the rounding: 32 roundoffs of its origin.
  PARRAY_INLINE void prepare_boxes(std::uint32_t i) {
    const Vec3<B> o = load_store_lanes(paths_.origin, i);
    const Vec3<B> d = load_store_lanes(paths_.direction, i);
    const B zero(Store(0));
    const B one(Store(1));
    const B reach = max_of(max_of(max_of(o.x, -o.x), max_of(o.y, -o.y)), max_of(o.z, -o.z));
    const B margin = B(Store(32) * RealTraits<Store>::unit_roundoff) * reach;
    const Vec3<B> inverse{one / d.x, one / d.y, one / d.z};
    const auto x_down = inverse.x < zero;
    const auto y_down = inverse.y < zero;
    const auto z_down = inverse.z < zero;
    const Vec3<B> shift{select(x_down, -margin, margin), select(y_down, -margin, margin),
                        select(z_down, -margin, margin)};
    queries_.inverse.store(i, inverse);
    queries_.near_origin.store(i, o + shift);
    queries_.far_origin.store(i, o - shift);
    octant_bits(x_down, y_down, z_down, &queries_.octant[i]);
  }

  static PARRAY_INLINE void octant_bits(typename B::Mask x, typename B::Mask y,
                                        typename B::Mask z, std::uint32_t* to) {
    const std::uint32_t bx = bits_of(x);
    const std::uint32_t by = bits_of(y);
    const std::uint32_t bz = bits_of(z);
    for (int k = 0; k < B::count; ++k) {
      to[k] = (bx >> k & 1) | (by >> k & 1) << 1 | (bz >> k & 1) << 2;
    }
  }

  /// Columns of the real type as lanes of the stored one.
  static PARRAY_INLINE Vec3<B> load_store_lanes(const VecColumns<Real>& columns, std::uint32_t i) {
    if constexpr (sizeof(Real) == sizeof(Store)) {
      return columns.template load<B>(i);
    } else {
      return {B::narrow(&columns.x[i]), B::narrow(&columns.y[i]), B::narrow(&columns.z[i])};
    }
  }

  template <typename T>
  PARRAY_INLINE Ray<T> ray(std::uint32_t i) const {
    return {vec_cast<T>(paths_.origin[i]), vec_cast<T>(paths_.direction[i]),
            T(queries_.inverse_square[i])};
  }

  PARRAY_INLINE SphereShape<Real> sphere(std::uint32_t slot) const {
    const SphereBlock<Store, width>& block = scene_.blocks[slot / width];
    const std::uint32_t lane = slot % width;
    return {{Real(block.x[lane]), Real(block.y[lane]), Real(block.z[lane])},
            Real(block.radius[lane])};
  }

  /// Open spheres [first, first + bar_bits), one after the other, for lanes of rays.
  template <bool Sides>
  PARRAY_INLINE void try_open_spheres(std::uint32_t first) {
    const std::uint32_t left = scene_.open_spheres - first;
    const std::uint32_t count = left < bar_bits ? left : bar_bits;
    for (std::uint32_t i = 0; i < paths_.count; ++i) {
      queries_.barred[i] = cannot_enter<Sides, bar_bits>(i, first);
    }
    for (std::uint32_t i = 0; i < paths_.count; i += L::count) {
      const Ray<L> rays(paths_.origin.template load<L>(i), paths_.direction.template load<L>(i),
                        L::load(&queries_.inverse_square[i]));
      const auto barred = L::Uint::load(&queries_.barred[i]);
      L nearest = L::load(&queries_.t[i]);
      auto slot = L::Uint::load(&queries_.slot[i]);
      for (std::uint32_t k = 0; k < count; ++k) {
        const SphereShape<Real> one = sphere(first + k);
        const SphereShape<L> same{vec_cast<L>(one.center), L(one.radius)};
        L t;
        const auto met = enters(rays, same, t);
        // Input order: an equal distance belongs to the earlier one.
        const auto better = met & (t < nearest) & disjoint(barred, typename L::Uint(1U << k));
        nearest = select(better, t, nearest);
        slot = select(better, typename L::Uint(first + k), slot);
      }
      nearest.store(&queries_.t[i]);
      slot.store(&queries_.slot[i]);
    }
  }

  /// Nearest exit out of the spheres that a path is inside of.
  PARRAY_INLINE void find_exit(std::uint32_t i) {
    for (std::uint32_t link = paths_.inside[i]; link != InsideLists::none;
         link = space_.inside.next(link)) {
      const std::uint32_t slot = space_.inside.sphere(link);
      const Ray<Real> r = ray<Real>(i);
      const Real t = slot == paths_.surface[i]
                         ? chord_from_surface(r, sphere(slot), paths_.normal[i])
                         : exit_distance(r, sphere(slot));
      if (t < queries_.t[i] || (t == queries_.t[i] && wins_tie(slot, queries_.slot[i]))) {
        queries_.t[i] = t;
        queries_.slot[i] = slot;
        queries_.leaving[i] = 1;
      }
    }
  }

  PARRAY_INLINE bool wins_tie(std::uint32_t slot, std::uint32_t other) const {
    return other == no_sphere || scene_.input_index[slot] < scene_.input_index[other];
  }

  /// Which of `count` slots from `first_slot` on a path cannot enter: the surface that it stands on,
  /// and what it is inside of (see sides.h).
  template <bool Sides, std::uint32_t count>
  PARRAY_INLINE std::uint32_t cannot_enter(std::uint32_t i, std::uint32_t first_slot) const {
    std::uint32_t lanes = bit_below<count>(paths_.surface[i] - first_slot);
    if constexpr (Sides) {
      for (std::uint32_t link = paths_.inside[i]; link != InsideLists::none;
           link = space_.inside.next(link)) {
        lanes |= bit_below<count>(space_.inside.sphere(link) - first_slot);
      }
    }
    return lanes;
  }
  template <std::uint32_t count>
  static PARRAY_INLINE std::uint32_t bit_below(std::uint32_t number) {
    return static_cast<std::uint32_t>(number < count) << (number % 32);
  }

  /// Improves the ray's nearest crossing with the spheres of a block.
  template <bool Sides>
  PARRAY_INLINE void try_block(std::uint32_t i, std::uint32_t index) {
    const SphereBlock<Store, width>& block = scene_.blocks[index];
    const std::uint32_t first_slot = index * width;
    const std::uint32_t excluded = cannot_enter<Sides, width>(i, first_slot);
    const Ray<L> r = ray<L>(i);
    for (int k = 0; k < width; k += L::count) {
      const SphereShape<L> spheres{
          {L::load(block.x + k), L::load(block.y + k), L::load(block.z + k)},
          L::load(block.radius + k)};
      L t;
      const auto met = enters(r, spheres, t) & (t <= L(queries_.t[i]));
      const std::uint32_t candidates = bits_of(met) & ~(excluded >> k);
      take_nearest(i, t, candidates, first_slot + static_cast<std::uint32_t>(k));
    }
  }

  PARRAY_INLINE void take_nearest(std::uint32_t i, const L& t, std::uint32_t candidates,
                                  std::uint32_t first_slot) {
    const L valid = select_bits(candidates, t, L(infinity));
    const Real nearest = least_of(valid);
    const std::uint32_t equal = bits_of(valid == L(nearest)) & candidates;
    const Real before = queries_.t[i];
    if ((equal & (equal - 1)) != 0 || (equal != 0 && nearest == before)) [[unlikely]] {
      take_tied(i, nearest, equal, first_slot);
      return;
    }
    const bool better = nearest < before;
    queries_.t[i] = better ? nearest : before;
    const std::uint32_t slot =
        first_slot + static_cast<std::uint32_t>(__builtin_ctz(equal | 1U << 31));
    queries_.slot[i] = better ? slot : queries_.slot[i];
    queries_.leaving[i] = better ? 0 : queries_.leaving[i];
  }

  /// The same where several spheres are equally near.
  void take_tied(std::uint32_t i, Real nearest, std::uint32_t equal, std::uint32_t first_slot) {
    for (; equal != 0; equal &= equal - 1) {
      const std::uint32_t slot = first_slot + static_cast<std::uint32_t>(__builtin_ctz(equal));
      if (nearest < queries_.t[i] || wins_tie(slot, queries_.slot[i])) {
        queries_.t[i] = nearest;
        queries_.slot[i] = slot;
        queries_.leaving[i] = 0;
      }
    }
  }

  /// Rays [begin, end) through the tree.
  template <bool Sides>
  void traverse(std::uint32_t begin, std::uint32_t end) {
    Waiting nodes[2];
    Waiting blocks[2];
    std::uint32_t top[group_size];
    for (std::uint32_t i = begin; i < end; ++i) {
      const std::uint32_t k = i - begin;
      stack_of(k).child[0] = 0;
      stack_of(k).t[0] = Store(0);
      top[k] = 1;
      nodes[0].ray[k] = k;
    }
    nodes[0].count = end - begin;
    for (int now = 0; nodes[now].count + blocks[now].count > 0; now ^= 1) {
      nodes[now ^ 1].count = 0;
      blocks[now ^ 1].count = 0;
      for (std::uint32_t n = 0; n < nodes[now].count; ++n) {
        const std::uint32_t k = nodes[now].ray[n];
        top[k] = step_node(begin + k, stack_of(k), top[k]);
        wait_for_next(k, top[k], nodes[now ^ 1], blocks[now]);
      }
      for (std::uint32_t n = 0; n < blocks[now].count; ++n) {
        const std::uint32_t k = blocks[now].ray[n];
        const Stack stack = stack_of(k);
        try_block<Sides>(begin + k, stack.child[top[k] - 1] & ~ChildRef::is_block);
        top[k] = drop_farther(queries_.t[begin + k], stack, top[k] - 1);
        wait_for_next(k, top[k], nodes[now ^ 1], blocks[now ^ 1]);
      }
    }
  }

  struct Stack {
    Store* t;
    std::uint32_t* child;
  };
  PARRAY_INLINE Stack stack_of(std::uint32_t k) const {
    const std::uint32_t at = k * scene_.stack_size;
    return {space_.stack_t + at, space_.stack_child + at};
  }

  /// Queues a ray for what lies on top of its stack, if anything does.
  PARRAY_INLINE void wait_for_next(std::uint32_t k, std::uint32_t top, Waiting& nodes,
                                   Waiting& blocks) const {
    const std::uint32_t child = stack_of(k).child[top == 0 ? 0 : top - 1];
    const std::uint32_t pending = top == 0 ? 0U : 1U;
    const std::uint32_t block = child / ChildRef::is_block & pending;
    nodes.ray[nodes.count] = k;
    blocks.ray[blocks.count] = k;
    nodes.count += pending ^ block;
    blocks.count += block;
    if (scene_.prefetch) {
      fetch(child);
    }
  }

  PARRAY_INLINE void fetch(std::uint32_t child) const {
    const bool is_block = (child & ChildRef::is_block) != 0;
    const char* from =
        is_block ? reinterpret_cast<const char*>(scene_.blocks + (child & ~ChildRef::is_block))
                 : reinterpret_cast<const char*>(scene_.nodes + child);
    for (std::size_t line = 0; line < sizeof(SphereBlock<Store, width>); line += 64) {
      __builtin_prefetch(from + line);
    }
    if (!is_block) {
      for (std::size_t line = sizeof(SphereBlock<Store, width>);
           line < sizeof(WideNode<Store, width>); line += 64) {
        __builtin_prefetch(from + line);
      }
    }
  }

  /// Replaces the node on top of the stack by those of its children that the ray meets before its
  /// nearest crossing; returns the new height.
  PARRAY_INLINE std::uint32_t step_node(std::uint32_t i, Stack stack, std::uint32_t top) const {
    --top;
    const WideNode<Store, width>& node = scene_.nodes[stack.child[top]];
    const std::uint32_t octant = queries_.octant[i];
    const Store* near_x = node.planes[(octant & 1) * 3];
    const Store* near_y = node.planes[(octant >> 1 & 1) * 3 + 1];
    const Store* near_z = node.planes[(octant >> 2) * 3 + 2];
    const Store* far_x = node.planes[(~octant & 1) * 3];
    const Store* far_y = node.planes[(~octant >> 1 & 1) * 3 + 1];
    const Store* far_z = node.planes[(~octant >> 2 & 1) * 3 + 2];
    const B inverse_x(queries_.inverse.x[i]);
    const B inverse_y(queries_.inverse.y[i]);
    const B inverse_z(queries_.inverse.z[i]);
    const B tx = (B::load(near_x) - B(queries_.near_origin.x[i])) * inverse_x;
    const B ty = (B::load(near_y) - B(queries_.near_origin.y[i])) * inverse_y;
    const B tz = (B::load(near_z) - B(queries_.near_origin.z[i])) * inverse_z;
    const B ux = (B::load(far_x) - B(queries_.far_origin.x[i])) * inverse_x;
    const B uy = (B::load(far_y) - B(queries_.far_origin.y[i])) * inverse_y;
    const B uz = (B::load(far_z) - B(queries_.far_origin.z[i])) * inverse_z;
    // A NaN (the origin on a plane that the ray runs along) constrains nothing: see max_of.
    const B near = max_of(max_of(tx, ty), max_of(tz, B(Store(0))));
    const B far = min_of(min_of(ux, uy), min_of(uz, B(nearest_bound(queries_.t[i]))));
    const std::uint8_t* order = node.order[octant];
    const B ordered = permute(near, order);
    const std::uint32_t met = bits_of(ordered <= permute(far, order));
    compress_store(stack.t + top, met, ordered);
    compress_store(stack.child + top, met, permute(B::Uint::load(node.child), order));
    return top + static_cast<std::uint32_t>(__builtin_popcount(met));
  }

  /// The nearest crossing as the stored type, not rounded down.
  static PARRAY_INLINE Store nearest_bound(Real t) {
    if constexpr (sizeof(Real) == sizeof(Store)) {
      return t;
    } else {
      return static_cast<Store>(t) * (Store(1) + 4 * RealTraits<Store>::unit_roundoff);
    }
  }

  /// Removes pending children that begin beyond the nearest crossing; returns the new height.
  static PARRAY_INLINE std::uint32_t drop_farther(Real t, Stack stack, std::uint32_t top) {
    const B bound(nearest_bound(t));
    std::uint32_t kept = 0;
    std::uint32_t k = 0;
    do {
      const B child_t = B::load(stack.t + k);
      const auto child = B::Uint::load(stack.child + k);
      const std::uint32_t left = top - k;
      const std::uint32_t present = left >= width ? (1U << width) - 1U : (1U << left) - 1U;
      const std::uint32_t keep = bits_of(child_t <= bound) & present;
      compress_store(stack.t + kept, keep, child_t);
      compress_store(stack.child + kept, keep, child);
      kept += static_cast<std::uint32_t>(__builtin_popcount(keep));
      k += width;
    } while (k < top);
    return kept;
  }

  const SceneTables& scene_;
  Paths<Real>& paths_;
  Queries<Real, Store>& queries_;
  Space& space_;
};

}  // namespace parray
