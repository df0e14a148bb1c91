#pragma once

#include <cstdint>
#include <limits>

#include "common/trace/bvh/bvh_view.h"
#include "common/trace/bvh/lane_loads.h"
#include "common/trace/bvh/nearest_crossings.h"
#include "common/trace/bvh/ray_columns.h"
#include "common/trace/bvh/ray_groups.h"

/// Finds the first surfaces of beams. A beam is a run of neighbouring rays, such as the camera rays
/// of a few pixels. Their directions have the same signs. The beam visits each node once: one test
/// with intervals finds the children that any of its rays may meet. Source of such tests: Boulos,
/// Wald, Shirley, "Geometric and arithmetic culling methods for entire ray packets", 2006.
namespace parray::trace {

/// The least and the greatest number of a column, in every lane.
template <typename B>
struct Interval {
  B least, greatest;

  PARRAY_INLINE explicit Interval(const B& first) : least(first), greatest(first) {}
  PARRAY_INLINE void add(const B& value) {
    least = min_of(value, least);
    greatest = max_of(value, greatest);
  }
  PARRAY_INLINE void spread() {
    least = least_of(least);
    greatest = -least_of(-greatest);
  }
};

/// The rays of a beam as intervals of their numbers along one axis, the same in every lane. A box
/// that a ray of the beam meets, by the rules of Slab, is met by the beam.
template <typename B>
struct BeamSlab {
  using Store = typename B::Scalar;

  B least_inverse, greatest_inverse;  ///< of the inverses of Slab
  bool down;
  B near_origin, far_origin;  ///< for planes on the near and on the far side

  /// See Slab for `margin` and `steepest`.
  PARRAY_INLINE BeamSlab(const Interval<B>& origin, const Interval<B>& direction, const B& margin,
                         const B& steepest)
      : least_inverse(inverse(direction.greatest, steepest)),
        greatest_inverse(inverse(direction.least, steepest)),
        down(first_of(greatest_inverse) < Store(0)),
        near_origin(down ? origin.least - margin : origin.greatest + margin),
        far_origin(down ? origin.greatest + margin : origin.least - margin) {}

  static PARRAY_INLINE B inverse(const B& direction, const B& steepest) {
    return min_of(max_of(B(Store(1)) / direction, -steepest), steepest);
  }
  /// Returns whether all directions have the same sign.
  [[nodiscard]] PARRAY_INLINE bool is_one_way() const {
    return down == (first_of(least_inverse) < Store(0));
  }

  // (plane - origin) x inverse rounds like a shift of the plane by 2 roundoffs of the difference.
  // Rounding keeps order, so each bound is that of the interval's worst ray.
  PARRAY_INLINE B enters_at(const B& plane) const {
    const B away = plane - near_origin;
    return min_of(away * least_inverse, away * greatest_inverse);
  }
  PARRAY_INLINE B leaves_at(const B& plane) const {
    const B away = plane - far_origin;
    return max_of(away * least_inverse, away * greatest_inverse);
  }
};

/// `L` are lanes of the real type, `B` lanes of the stored type.
template <typename L, typename B>
class BeamSearch {
 public:
  using Real = typename L::Scalar;
  using Store = typename B::Scalar;
  static constexpr int width = B::count;
  using Space = TraversalSpace<Real, Store>;
  static constexpr std::uint32_t no_octant = 8;
  static constexpr std::uint32_t all_lanes = (1U << width) - 1U;

  /// `rays` must stand on no surface and be inside no shape. `space` holds what Traversal has
  /// prepared for them.
  PARRAY_INLINE BeamSearch(const BvhView<Store, width>& bvh, const RayColumns<Real>& rays,
                           Space& space)
      : bvh_(bvh),
        rays_(rays),
        queries_(space.queries),
        nearest_(bvh.labels, 0, space.queries),
        space_(space) {}

  /// Finds the nearest crossings of all rays that form beams of at most `space.beam` >= `width`
  /// rays. Sets queries.octant of all rays: no_octant for these rays, otherwise another number.
  void find() {
    const std::uint32_t most = space_.beam / width * width;
    for (std::uint32_t i = 0; i < rays_.count; i += most) {
      const std::uint32_t left = rays_.count - i;
      const std::uint32_t end = i + (left < most ? left / width * width : most);
      const bool found = i < end && search(i, end);
      for (std::uint32_t k = i; k < i + most; k += width) {
        typename B::Uint(found && k < end ? no_octant : 0).store(&queries_.octant[k]);
      }
    }
  }

 private:
  struct Beam {
    RayGroup<width> signs;
    BeamSlab<B> x, y, z;
    std::uint32_t begin, end;
    B bound;  ///< the farthest of the rays' nearest crossings, in every lane
  };

  /// Returns the farthest of the nearest crossings of rays [begin, end), not rounded down.
  PARRAY_INLINE B farthest(std::uint32_t begin, std::uint32_t end) const {
    L most_t = L::load(&queries_.t[begin]);
    for (std::uint32_t i = begin + L::count; i < end; i += L::count) {
      most_t = max_of(L::load(&queries_.t[i]), most_t);
    }
    return bound_of<B>(-least_of(-most_t));
  }

  /// Finds the nearest crossings of rays [begin, end). False: their directions have different
  /// signs, or a number is NaN, so nothing was done.
  bool search(std::uint32_t begin, std::uint32_t end) {
    Vec3<B> o = stored_lanes<B>(rays_.origin, begin);
    Vec3<B> d = stored_lanes<B>(rays_.direction, begin);
    Interval<B> origin_x(o.x), origin_y(o.y), origin_z(o.z);
    Interval<B> x(d.x), y(d.y), z(d.z);
    B sum = (o.x + o.y + o.z) + (d.x + d.y + d.z);
    for (std::uint32_t i = begin + width; i < end; i += width) {
      o = stored_lanes<B>(rays_.origin, i);
      d = stored_lanes<B>(rays_.direction, i);
      origin_x.add(o.x), origin_y.add(o.y), origin_z.add(o.z);
      x.add(d.x), y.add(d.y), z.add(d.z);
      sum = sum + ((o.x + o.y + o.z) + (d.x + d.y + d.z));
    }
    for (Interval<B>* interval : {&origin_x, &origin_y, &origin_z, &x, &y, &z}) interval->spread();
    const auto size = [](const Interval<B>& interval) {
      return max_of(interval.greatest, -interval.least);
    };
    const B reach = max_of(max_of(size(origin_x), size(origin_y)), size(origin_z));
    const B margin = B(Store(32) * RealTraits<Store>::unit_roundoff) * reach;
    const B steepest = Slab<B>::steepest(reach);
    const BeamSlab<B> slab_x(origin_x, x, margin, steepest);
    const BeamSlab<B> slab_y(origin_y, y, margin, steepest);
    const BeamSlab<B> slab_z(origin_z, z, margin, steepest);
    if (!(slab_x.is_one_way() && slab_y.is_one_way() && slab_z.is_one_way()) ||
        bits_of(sum == sum) != all_lanes) {
      return false;
    }
    const std::uint32_t octant = slab_x.down + 2U * slab_y.down + 4U * slab_z.down;
    Beam beam{{nullptr, end - begin, octant}, slab_x, slab_y, slab_z, begin, end,
              farthest(begin, end)};
    for (std::uint32_t block = 0; block * width < bvh_.open_spheres; ++block) {
      try_block(beam, block);
    }
    if (bvh_.node_count > 0) search_tree(beam);
    return true;
  }

  void search_tree(Beam& beam) {
    Store* const stack_t = space_.stack_t;
    std::uint32_t* const stack_child = space_.stack_child;
    std::uint32_t top = push_children(beam, bvh_.nodes[0], 0);
    while (top > 0) {
      --top;
      if (!(stack_t[top] <= first_of(beam.bound))) continue;
      const std::uint32_t child = stack_child[top];
      if ((child & ChildRef::is_block) == 0) {
        top = push_children(beam, bvh_.nodes[child], top);
      } else {
        try_block(beam, child & ChildRef::number);
      }
    }
  }

  /// Adds the children of a node that the beam may meet to the stack, and returns its new top.
  PARRAY_INLINE std::uint32_t push_children(const Beam& beam, const WideNode<Store, width>& node,
                                            std::uint32_t top) const {
    const B near = enters_at(beam, near_planes<B>(beam.signs, node));
    const B far = leaves_at(beam, far_planes<B>(beam.signs, node));
    const auto order = B::load_order(node.order[beam.signs.octant]);
    const B ordered = permute(near, order);
    const std::uint32_t met = bits_of(ordered <= permute(far, order));
    compress_store(space_.stack_t + top, met, ordered);
    compress_store(space_.stack_child + top, met, permute(B::Uint::load(node.child), order));
    return top + static_cast<std::uint32_t>(__builtin_popcount(met));
  }

  static PARRAY_INLINE B enters_at(const Beam& beam, const Vec3<B>& planes) {
    return max_of(max_of(beam.x.enters_at(planes.x), beam.y.enters_at(planes.y)),
                  max_of(beam.z.enters_at(planes.z), B(Store(0))));
  }
  static PARRAY_INLINE B leaves_at(const Beam& beam, const Vec3<B>& planes) {
    return min_of(min_of(beam.x.leaves_at(planes.x), beam.y.leaves_at(planes.y)),
                  min_of(beam.z.leaves_at(planes.z), beam.bound));
  }

  /// Tests the spheres of a block whose boxes the beam may meet. These boxes grow like those of
  /// nodes: see WideBvh.
  PARRAY_INLINE void try_block(Beam& beam, std::uint32_t index) {
    const SphereShape<B> spheres = spheres_of<B>(bvh_.blocks[index], 0);
    const Vec3<B>& c = spheres.center;
    const auto size = [](const B& a) { return max_of(a, -a); };
    const B largest = size(c.x) + size(c.y) + size(c.z) + spheres.radius;
    const B half = spheres.radius + B(Store(40) * RealTraits<Store>::unit_roundoff) * largest;
    const std::uint32_t octant = beam.signs.octant;
    const auto toward = [&](std::uint32_t axis) {
      return (octant >> axis & 1U) != 0 ? half : -half;
    };
    const Vec3<B> reach{toward(0), toward(1), toward(2)};
    const B near = enters_at(beam, c + reach);
    const B far = leaves_at(beam, c - reach);
    std::uint32_t met = bits_of((near <= far) & (half == half));
    if (met == 0) return;
    for (; met != 0; met &= met - 1) {
      try_sphere(beam.begin, beam.end,
                 index * width + static_cast<std::uint32_t>(__builtin_ctz(met)));
    }
    beam.bound = farthest(beam.begin, beam.end);
  }

  /// Tests rays [begin, end) against the sphere in a slot.
  PARRAY_INLINE void try_sphere(std::uint32_t begin, std::uint32_t end, std::uint32_t slot) {
    const SphereShape<Real> one = shape_at<Real>(bvh_.blocks, slot);
    const SphereShape<L> same{vec_cast<L>(one.center), L(one.radius)};
    for (std::uint32_t i = begin; i < end; i += L::count) {
      const Ray<L> rays(rays_.origin.template load<L>(i), rays_.direction.template load<L>(i),
                        L::load(&queries_.inverse_square[i]));
      const ClosestApproach<L> passage(rays, same);
      const auto met = passage.approaches();
      if (!any(met)) continue;
      const L t = entry_distance(passage.foot, passage.depth_squared, rays.inverse_square);
      const L before = L::load(&queries_.t[i]);
      const auto better = met & (t < before);
      if (const std::uint32_t tied = bits_of(met & (t == before)); tied != 0) [[unlikely]] {
        take_tied(i, tied, slot);
      }
      select(better, t, before).store(&queries_.t[i]);
      select(better, typename L::Uint(slot), L::Uint::load(&queries_.slot[i]))
          .store(&queries_.slot[i]);
    }
  }

  /// Gives a sphere the rays in lanes `tied` that meet it as soon as another, if it precedes that.
  void take_tied(std::uint32_t i, std::uint32_t tied, std::uint32_t slot) {
    for (; tied != 0; tied &= tied - 1) {
      std::uint32_t& other = queries_.slot[i + static_cast<std::uint32_t>(__builtin_ctz(tied))];
      if (nearest_.wins_tie(slot, other)) other = slot;
    }
  }

  const BvhView<Store, width> bvh_;
  const RayColumns<Real>& rays_;
  Queries<Real, Store>& queries_;
  NearestCrossings<L, Store> nearest_;
  Space& space_;
};

}  // namespace parray::trace
