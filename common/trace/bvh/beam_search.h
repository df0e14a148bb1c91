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

/// The least and the greatest components of some vectors.
template <typename B>
struct VectorRange {
  Vec3<B> least, greatest;

  PARRAY_INLINE explicit VectorRange(const Vec3<B>& first) : least(first), greatest(first) {}
  PARRAY_INLINE void add(const Vec3<B>& v) {
    least = {min_of(v.x, least.x), min_of(v.y, least.y), min_of(v.z, least.z)};
    greatest = {max_of(v.x, greatest.x), max_of(v.y, greatest.y), max_of(v.z, greatest.z)};
  }
  /// Makes all lanes equal.
  PARRAY_INLINE void spread() {
    least = {least_of(least.x), least_of(least.y), least_of(least.z)};
    greatest = {-least_of(-greatest.x), -least_of(-greatest.y), -least_of(-greatest.z)};
  }
  [[nodiscard]] PARRAY_INLINE Vec3<B> half() const {
    return B(typename B::Scalar(0.5)) * (greatest - least);
  }
  [[nodiscard]] PARRAY_INLINE Vec3<B> middle() const { return least + half(); }
};

/// The rays of a beam as intervals of their numbers along one axis, the same in every lane. A box
/// that a ray of the beam meets, by the rules of Slab, is met by the beam.
template <typename B>
struct BeamSlab {
  using Store = typename B::Scalar;

  B least_inverse, greatest_inverse;  ///< of the inverses of Slab
  bool down;
  B near_origin, far_origin;  ///< for planes on the near and on the far side

  /// Takes the least and the greatest coordinate of origins and directions. See Slab for `margin`
  /// and `steepest`.
  PARRAY_INLINE BeamSlab(const B& least, const B& greatest, const B& least_direction,
                         const B& greatest_direction, const B& margin, const B& steepest)
      : least_inverse(inverse(greatest_direction, steepest)),
        greatest_inverse(inverse(least_direction, steepest)),
        down(first_of(greatest_inverse) < Store(0)),
        near_origin(down ? least - margin : greatest + margin),
        far_origin(down ? greatest + margin : least - margin) {}

  static PARRAY_INLINE B inverse(const B& direction, const B& steepest) {
    const B same(first_of(direction));  // because lanes with 0 may differ in its sign
    return min_of(max_of(B(Store(1)) / same, -steepest), steepest);
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

/// A cone around the rays of a beam: ray i is origin_i + t direction_i with |origin_i - apex| <=
/// `blur` and |direction_i - axis| <= `slope`. All lanes have the same cone. `axis` has unit
/// length.
template <typename B>
struct BeamCone {
  using Store = typename B::Scalar;

  Vec3<B> apex, axis;
  B blur, slope;

  PARRAY_INLINE BeamCone(const VectorRange<B>& origins, const VectorRange<B>& directions)
      : apex(origins.middle()), axis(normalize(directions.middle())), blur(length(origins.half())) {
    const B change = length(directions.middle()) - B(Store(1));
    const B rounding(Store(16) * RealTraits<Store>::unit_roundoff);
    slope = length(directions.half()) + max_of(change, -change) + rounding;
  }

  /// Returns the sum of the absolute coordinates.
  static PARRAY_INLINE B size(const Vec3<B>& v) {
    return max_of(v.x, -v.x) + max_of(v.y, -v.y) + max_of(v.z, -v.z);
  }
  /// Returns whether all rays of the beam miss a sphere, beyond doubt. Let the sphere's centre lie
  /// `along` the axis and `across` it. A ray that enters needs a t at which it is within radius +
  /// blur + slope t of apex + t axis. The least of that distance - slope t is across sqrt(1 -
  /// slope^2) - slope along. The radius grows like the boxes of WideBvh. False for NaN.
  PARRAY_INLINE MaskOf<B> misses(const SphereShape<B>& sphere) const {
    const Vec3<B> way = sphere.center - apex;
    const B along = dot(way, axis);
    const Vec3<B> across = way - along * axis;
    const B grown = B(Store(64) * RealTraits<Store>::unit_roundoff) *
                    (size(sphere.center) + size(apex) + sphere.radius + blur);
    const B reach = sphere.radius + blur + grown + slope * along;
    const B square = dot(across, across) * (B(Store(1)) - slope * slope);
    return ((reach < B(Store(0))) | (square > reach * reach)) & (slope < B(Store(1)));
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

  /// `rays` must stand on no surface and be inside no shape. `space` holds what Traversal has
  /// prepared for them.
  PARRAY_INLINE BeamSearch(const BvhView<Store, width>& bvh, const RayColumns<Real>& rays,
                           Space& space)
      : bvh_(bvh), rays_(rays), queries_(space.queries), space_(space) {}

  /// Takes the rays, except for the last rays.count % width, in beams of at most `space.beam` rays,
  /// which must be `width` or more. Returns the number of rays taken. Finds their crossings with
  /// open spheres (those outside the tree), and with the tree if the directions of a beam have the
  /// same signs. Sets queries.octant to 0 for rays that the
  /// caller must still search the tree with, and to no_octant for all others.
  std::uint32_t find() {
    const std::uint32_t most = space_.beam / width * width;
    const std::uint32_t all = rays_.count / width * width;
    for (std::uint32_t i = 0; i < rays_.count; i += most) {
      const std::uint32_t end = i + most < all ? i + most : all;
      const bool found = i < end && search(i, end);
      for (std::uint32_t k = i; k < i + most && k < rays_.count; k += width) {
        typename B::Uint(found && k < end ? no_octant : 0).store(&queries_.octant[k]);
      }
    }
    return all;
  }

 private:
  static constexpr std::uint32_t all_lanes = (1U << width) - 1U;

  /// A beam of rays [begin, end).
  struct Beam {
    std::uint32_t begin, end;
    BeamCone<B> cone;
    B bound;  ///< the farthest of the rays' nearest crossings, in every lane
  };
  struct Slabs {
    BeamSlab<B> x, y, z;
    RayGroup<width> signs;
  };

  /// Finds the nearest crossings of rays [begin, end). False: their directions have different
  /// signs, or a number is NaN, so only the open spheres were tested.
  bool search(std::uint32_t begin, std::uint32_t end) {
    const auto origin = [&](std::uint32_t i) { return stored_lanes<B>(rays_.origin, i); };
    const auto direction = [&](std::uint32_t i) { return stored_lanes<B>(rays_.direction, i); };
    VectorRange<B> o(origin(begin));
    VectorRange<B> d(direction(begin));
    for (std::uint32_t i = begin + width; i < end; i += width) {
      o.add(origin(i));
      d.add(direction(i));
    }
    o.spread();
    d.spread();
    Beam beam{begin, end, BeamCone<B>(o, d), B(std::numeric_limits<Store>::infinity())};
    for (std::uint32_t block = 0; block * width < bvh_.open_spheres; ++block) {
      try_block(beam, block);
    }
    if (bvh_.node_count == 0) return true;
    std::uint32_t numbers = all_lanes;
    for (std::uint32_t i = begin; i < end; i += width) {
      const Vec3<B> sum = origin(i) + direction(i);
      numbers &= bits_of(dot(sum, sum) < B(std::numeric_limits<Store>::infinity()));
    }
    const B reach = BeamCone<B>::size(beam.cone.apex) + beam.cone.blur;
    const B margin = B(Store(32) * RealTraits<Store>::unit_roundoff) * reach;
    const B steepest = Slab<B>::steepest(reach);
    const BeamSlab<B> x(o.least.x, o.greatest.x, d.least.x, d.greatest.x, margin, steepest);
    const BeamSlab<B> y(o.least.y, o.greatest.y, d.least.y, d.greatest.y, margin, steepest);
    const BeamSlab<B> z(o.least.z, o.greatest.z, d.least.z, d.greatest.z, margin, steepest);
    if (!x.is_one_way() || !y.is_one_way() || !z.is_one_way() || numbers != all_lanes) return false;
    search_tree(beam, {x, y, z, {nullptr, end - begin, x.down + 2U * y.down + 4U * z.down}});
    return true;
  }

  void search_tree(Beam& beam, const Slabs& slabs) {
    Store* const stack_t = space_.stack_t;
    std::uint32_t* const stack_child = space_.stack_child;
    std::uint32_t top = push_children(beam.bound, slabs, bvh_.nodes[0], 0);
    while (top > 0) {
      --top;
      if (!(stack_t[top] <= first_of(beam.bound))) continue;
      const std::uint32_t child = stack_child[top];
      if ((child & ChildRef::is_block) == 0) {
        top = push_children(beam.bound, slabs, bvh_.nodes[child], top);
      } else {
        try_block(beam, child & ChildRef::number);
      }
    }
  }

  /// Adds the children of a node that the beam may meet to the stack, and returns its new top.
  PARRAY_INLINE std::uint32_t push_children(const B& bound, const Slabs& slabs,
                                            const WideNode<Store, width>& node,
                                            std::uint32_t top) const {
    const Vec3<B> at_near = planes_of<B>(slabs.signs, node, 0);
    const Vec3<B> at_far = planes_of<B>(slabs.signs, node, 1);
    const B near = max_of(max_of(slabs.x.enters_at(at_near.x), slabs.y.enters_at(at_near.y)),
                          max_of(slabs.z.enters_at(at_near.z), B(Store(0))));
    const B far = min_of(min_of(slabs.x.leaves_at(at_far.x), slabs.y.leaves_at(at_far.y)),
                         min_of(slabs.z.leaves_at(at_far.z), bound));
    const auto order = B::load_order(node.order[slabs.signs.octant]);
    const B ordered = permute(near, order);
    const std::uint32_t met = bits_of(ordered <= permute(far, order));
    compress_store(space_.stack_t + top, met, ordered);
    compress_store(space_.stack_child + top, met, permute(B::Uint::load(node.child), order));
    return top + static_cast<std::uint32_t>(__builtin_popcount(met));
  }

  /// Tests the spheres of a block that the beam's cone may meet.
  PARRAY_INLINE void try_block(Beam& beam, std::uint32_t index) {
    const SphereShape<B> spheres = spheres_of<B>(bvh_.blocks[index], 0);
    std::uint32_t met =
        bits_of(spheres.radius == spheres.radius) & ~bits_of(beam.cone.misses(spheres));
    if (met == 0) return;
    for (; met != 0; met &= met - 1) {
      try_sphere(beam.begin, beam.end,
                 index * width + static_cast<std::uint32_t>(__builtin_ctz(met)));
    }
    L most_t = L::load(&queries_.t[beam.begin]);
    for (std::uint32_t i = beam.begin + L::count; i < beam.end; i += L::count) {
      most_t = max_of(L::load(&queries_.t[i]), most_t);
    }
    beam.bound = bound_of<B>(-least_of(-most_t));  // not rounded down
  }

  /// Tests rays [begin, end) against the sphere in a slot.
  PARRAY_INLINE void try_sphere(std::uint32_t begin, std::uint32_t end, std::uint32_t slot) {
    const SphereShape<Real> one = shape_at<Real>(bvh_.blocks, slot);
    const SphereShape<L> same{vec_cast<L>(one.center), L(one.radius)};
    const NearestCrossings<L, Store> nearest(bvh_.labels, 0, queries_);
    for (std::uint32_t i = begin; i < end; i += L::count) {
      const Ray<L> rays(rays_.origin.template load<L>(i), rays_.direction.template load<L>(i),
                        L::load(&queries_.inverse_square[i]));
      const ClosestApproach<L> passage(rays, same);
      const auto met = passage.approaches();
      if (!any(met)) continue;
      const L t = entry_distance(passage.foot, passage.depth_squared, rays.inverse_square);
      const L before = L::load(&queries_.t[i]);
      const auto better = met & (t < before);
      for (std::uint32_t tied = bits_of(met & (t == before)); tied != 0; tied &= tied - 1) {
        std::uint32_t& other = queries_.slot[i + static_cast<std::uint32_t>(__builtin_ctz(tied))];
        if (nearest.wins_tie(slot, other)) other = slot;
      }
      select(better, t, before).store(&queries_.t[i]);
      select(better, typename L::Uint(slot), L::Uint::load(&queries_.slot[i]))
          .store(&queries_.slot[i]);
    }
  }

  const BvhView<Store, width> bvh_;
  const RayColumns<Real>& rays_;
  Queries<Real, Store>& queries_;
  Space& space_;
};

}  // namespace parray::trace
