#pragma once

#include <cstdint>
#include <limits>

#include "common/trace/bvh/traversal.h"
#include "common/trace/integrator/path_columns.h"
#include "common/trace/integrator/sample_sums.h"

/// Traces the paths of a batch, bounce by bounce. Each bounce finds the next surface of all paths.
/// Then it scatters all paths that met the same type of material, one vector at a time. Every path
/// has the same arithmetic as in trace_sample() of path.h, to the bit.
namespace parray::trace {

/// `L` are lanes of the type of path computations, `B` lanes of the stored type, `D` lanes of
/// double. `InsideStack`: paths can be inside a shape; `Capsules`: the scene has capsules
/// (KernelFeatures).
template <typename L, typename B, typename D, bool InsideStack, bool Capsules>
class Wavefront {
 public:
  using Real = typename L::Scalar;
  using Store = typename B::Scalar;
  using Uint = typename L::Uint;
  using SceneTables = KernelScene<Real, Store, B::count>;
  using Space = Workspace<Real, Store>;

  PARRAY_INLINE Wavefront(const SceneTables& scene, Space& space) : scene_(scene), space_(space) {}

  /// Adds the samples of a batch to the pixels of its row, and to `counts`.
  void trace(const SampleBatch& batch, PixelSums* row, TraceCounts& counts) {
    begin(batch);
    for (std::uint32_t bounce = 0; bounce < scene_.max_depth && space_.paths.count > 0; ++bounce) {
      find_surfaces(counts);
      add_sky();
      scatter_all_diffuse(bounce);
      scatter_all_metal(bounce);
      if constexpr (InsideStack) scatter_all_dielectric(bounce);
    }
    count_lost(counts);
    add_samples(batch, space_.radiance, row, counts);
  }

  /// Finds the next surface of all paths: sets `t`, `slot` and `leaving` of space.queries.
  PARRAY_INLINE void find() {
    Traversal<L, B>(scene_.bvh, space_.paths, space_).template find_all<InsideStack, Capsules>();
    if constexpr (Capsules) {
      Traversal<L, B, CapsuleBlock> capsules(scene_.capsules, space_.paths, space_);
      capsules.template find_nearer<InsideStack>(scene_.bvh.node_count > 0);
    }
  }

  /// Makes the camera rays of a batch.
  PARRAY_INLINE void begin(const SampleBatch& batch) {
    space_.sample_number = batch.sample;
    Paths<Real>& paths = space_.paths;
    paths.count = batch.count;
    space_.beam = rays_of_beam(batch);
    for (std::uint32_t i = 0; i < batch.count; i += lanes) {
      const Uint column = Uint::load(&batch.column[i]);
      const Uint pixel = Uint(batch.y * scene_.width) + column;
      pixel.store(&space_.pixel[i]);
      const RandomAddress<Uint> random(scene_.seed, pixel, Uint::load(&batch.sample[i]),
                                       scene_.sampler);
      const Ray<L> ray = scene_.view.template ray<L>(column, Uint(batch.y), random);
      paths.origin.store(i, ray.origin);
      paths.direction.store(i, ray.direction);
      const L one(Real(1));
      paths.throughput.store(i, Vec3<L>{one, one, one});
      Uint(no_shape).store(&paths.surface[i]);
    }
    for (std::uint32_t i = 0; i < batch.count; ++i) {
      paths.sample[i] = i;
      for (double& channel : space_.radiance.of[i]) {
        channel = RadianceScale::shift;  // radiance 0, which remains if max_depth ends the path
      }
    }
    if constexpr (InsideStack) {
      space_.inside.clear();
      for (std::uint32_t i = 0; i < batch.count; ++i) {
        paths.inside[i] =
            inside_at(scene_, batch.column[i], batch.y, paths.origin[i], space_.inside);
      }
    }
  }

 private:
  static constexpr std::uint32_t lanes = L::count;
  static constexpr std::uint32_t most_of_beam = 64;  ///< more would bring nothing

  /// Returns how many neighbouring camera rays search the tree together: those of a few pixels. The
  /// more shapes there are, the fewer pixels see the same ones.
  PARRAY_INLINE std::uint32_t rays_of_beam(const SampleBatch& batch) const {
    if (Capsules || scene_.start.numbers != nullptr) return 0;
    const std::uint32_t nodes = scene_.bvh.node_count;
    const std::uint32_t most_pixels = nodes < 4096 ? 8 : nodes < 65536 ? 2 : 1;
    const std::uint32_t pixels = batch.column[batch.count - 1] - batch.column[0] + 1;
    const std::uint32_t rays = most_pixels * batch.count / pixels;
    return rays < most_of_beam ? rays : most_of_beam;
  }

  static PARRAY_INLINE std::uint32_t first_bits(std::uint32_t count) {
    return count >= lanes ? (1U << lanes) - 1 : (1U << count) - 1;
  }

  /// Counts the light of the paths that max_depth cuts short.
  PARRAY_INLINE void count_lost(TraceCounts& counts) const {
    for (std::uint32_t i = 0; i < space_.paths.count; ++i) {
      const Vec3<Real> throughput = space_.paths.throughput[i];
      counts.lost += TraceCounts::lost_of(
          static_cast<double>(max_of(max_of(throughput.x, throughput.y), throughput.z)));
    }
  }

  /// Finds the next surface of all paths that bounds a body, and moves every path to the hits of
  /// its material's type or of the sky.
  PARRAY_INLINE void find_surfaces(TraceCounts& counts) {
    for (Hits<Real>& hits : space_.hits) hits.count = 0;
    for (std::uint32_t crossed = 0;; ++crossed) {
      counts.rays += space_.paths.count;
      find();
      sort_paths();
      space_.paths.count = 0;
      if constexpr (InsideStack) {
        crossings_remain_ = crossed == most_crossings;
        if (!crossings_remain_) move_crossing_paths();
      }
      if (space_.paths.count == 0) return;
    }
  }

  /// Adds every path to the hits.
  PARRAY_INLINE void sort_paths() {
    for (std::uint32_t i = 0; i < space_.paths.count; i += lanes) {
      sort(i, first_bits(space_.paths.count - i));
    }
  }

  /// Moves paths on that have met a surface inside another body of the same glass: from the hits of
  /// glass to the paths, beyond the surface. See InsideStack.
  PARRAY_INLINE void move_crossing_paths() {
    Hits<Real>& hits = space_.hits[static_cast<int>(MaterialType::dielectric)];
    std::uint32_t kept = 0;
    for (std::uint32_t i = 0; i < hits.count; i += lanes) {
      const std::uint32_t present = first_bits(hits.count - i);
      const std::uint32_t crossing = crossing_lanes(hits, i, present);
      if (crossing != 0) {
        const std::uint32_t n = space_.paths.count;
        const Meeting at = meet(hits, i, present);
        go_on(hits, i, crossing, at, at.incoming, hits.throughput.template load<L>(i));
        cross(hits, i, crossing, crossing, n);
      }
      if (kept != i || crossing != 0) keep(hits, i, present & ~crossing, kept);
      kept += static_cast<std::uint32_t>(__builtin_popcount(present & ~crossing));
    }
    hits.count = kept;
  }

  /// Returns the lanes of hits whose surface lies inside another body of the same glass.
  PARRAY_INLINE std::uint32_t crossing_lanes(const Hits<Real>& hits, std::uint32_t i,
                                             std::uint32_t present) const {
    const Uint none(InsideLists::none);
    const Uint inside = Uint::load(&hits.inside[i]);
    std::uint32_t left = ~bits_of(equal(inside, none)) & present;
    if (left == 0) return 0;
    // Most paths leave the only shape that they are inside of.
    const Uint others = space_.inside.next(select_bits(left, inside, Uint(0U)));
    left &= ~(bits_of(equal(others, none)) & bits_of(L::load(&hits.side[i]) > L(Real(0))));
    std::uint32_t crossing = 0;
    for (; left != 0; left &= left - 1) {
      const std::uint32_t k = static_cast<std::uint32_t>(__builtin_ctz(left));
      for (std::uint32_t link = hits.inside[i + k]; link != InsideLists::none;
           link = space_.inside.next(link)) {
        const std::uint32_t slot = space_.inside.shape(link);
        const std::uint32_t material =
            scene_.material_of[slot] >> scene_.material_bit >> MaterialRef::type_bits;
        if (slot != hits.slot[i + k] && material == hits.material[i + k]) crossing |= 1U << k;
      }
    }
    return crossing;
  }

  /// Moves the lanes `set` of hits i, i + 1 ... to place `to` <= i.
  static PARRAY_INLINE void keep(Hits<Real>& hits, std::uint32_t i, std::uint32_t set,
                                 std::uint32_t to) {
    hits.origin.compress(to, set, hits.origin.template load<L>(i));
    hits.direction.compress(to, set, hits.direction.template load<L>(i));
    hits.throughput.compress(to, set, hits.throughput.template load<L>(i));
    hits.old_normal.compress(to, set, hits.old_normal.template load<L>(i));
    for (Column<Real>* const column : {&hits.inverse_square, &hits.side, &hits.t}) {
      compress_store(&(*column)[to], set, L::load(&(*column)[i]));
    }
    for (Column<std::uint32_t>* const column :
         {&hits.sample, &hits.slot, &hits.material, &hits.inside}) {
      compress_store(&(*column)[to], set, Uint::load(&(*column)[i]));
    }
  }

  /// Adds paths i, i + 1 ..., of the lanes `present`, to the hits of their material's type or of
  /// the sky.
  PARRAY_INLINE void sort(std::uint32_t i, std::uint32_t present) {
    const L t = L::load(&space_.queries.t[i]);
    const MaskOf<L> met = t < L(std::numeric_limits<Real>::infinity());
    const std::uint32_t hit = bits_of(met) & present;
    const Uint slot = select(met, Uint::load(&space_.queries.slot[i]), Uint(0U));
    const Uint material = Uint::gather(scene_.material_of, slot) >> scene_.material_bit;
    const Uint type = material & Uint(MaterialRef::type);
    move_to_sky(i, present & ~hit);
    for (std::uint32_t kind = 0; kind < Space::sky; ++kind) {
      const std::uint32_t moved = bits_of(equal(type, Uint(kind))) & hit;
      if (moved != 0) move(space_.hits[kind], i, moved, slot, material >> MaterialRef::type_bits);
    }
  }

  PARRAY_INLINE void move_to_sky(std::uint32_t i, std::uint32_t moved) {
    Hits<Real>& to = space_.hits[Space::sky];
    const Paths<Real>& paths = space_.paths;
    to.throughput.compress(to.count, moved, paths.throughput.template load<L>(i));
    compress_store(&to.direction.y[to.count], moved, L::load(&paths.direction.y[i]));
    compress_store(&to.sample[to.count], moved, Uint::load(&paths.sample[i]));
    to.count += static_cast<std::uint32_t>(__builtin_popcount(moved));
  }

  PARRAY_INLINE void move(Hits<Real>& to, std::uint32_t i, std::uint32_t moved, const Uint& slot,
                          const Uint& material) {
    const Paths<Real>& paths = space_.paths;
    const std::uint32_t n = to.count;
    to.count = n + static_cast<std::uint32_t>(__builtin_popcount(moved));
    to.origin.compress(n, moved, paths.origin.template load<L>(i));
    to.direction.compress(n, moved, paths.direction.template load<L>(i));
    to.throughput.compress(n, moved, paths.throughput.template load<L>(i));
    compress_store(&to.inverse_square[n], moved, L::load(&space_.queries.inverse_square[i]));
    compress_store(&to.sample[n], moved, Uint::load(&paths.sample[i]));
    compress_store(&to.slot[n], moved, slot);
    compress_store(&to.material[n], moved, material);
    if constexpr (InsideStack) {
      const MaskOf<L> leaving = equal(Uint::load(&space_.queries.leaving[i]), Uint(1U));
      const MaskOf<L> itself = equal(Uint::load(&paths.surface[i]), slot);
      const L side = select(leaving, select(itself, L(Real(2)), L(Real(1))), L(Real(0)));
      compress_store(&to.side[n], moved, side);
      compress_store(&to.inside[n], moved, Uint::load(&paths.inside[i]));
      if (any(leaving)) {
        to.old_normal.compress(n, moved, paths.normal.template load<L>(i));
        compress_store(&to.t[n], moved, L::load(&space_.queries.t[i]));
      }
    }
  }

  PARRAY_INLINE void add_sky() {
    Hits<Real>& from = space_.hits[Space::sky];
    for (std::uint32_t i = 0; i < from.count; i += lanes) {
      from.throughput.store(i, from.throughput.template load<L>(i) *
                                   scene_.sky.radiance(L::load(&from.direction.y[i])));
    }
    write_radiance(from, from.throughput.x, 0);
    write_radiance(from, from.throughput.y, 1);
    write_radiance(from, from.throughput.z, 2);
  }

  /// Converts radiance like RadianceScale::to_fixed(). NaN stays NaN, because it is the second
  /// operand of each choice. The factor 0 x turns infinity into NaN.
  PARRAY_INLINE void write_radiance(const Hits<Real>& from, const Column<Real>& radiance,
                                    int channel) {
    for (std::uint32_t i = 0; i < from.count; i += D::count) {
      const D value = D::load(&radiance[i]);
      const D positive = max_of(D(0.0), value * D(scene_.to_fixed));
      const D bounded = min_of(D(RadianceScale::one), positive) + value * D(0.0);
      double fixed[D::count];
      (bounded + D(RadianceScale::shift)).store(fixed);
      const std::uint32_t left = from.count - i;
      for (std::uint32_t k = 0; k < (left < D::count ? left : D::count); ++k) {
        space_.radiance.of[from.sample[i + k]][channel] = fixed[k];
      }
    }
  }

  /// Returns the slots of a vector of hits; 0 for lanes without a hit.
  static PARRAY_INLINE Uint slots(const Hits<Real>& hits, std::uint32_t i, std::uint32_t present) {
    return select_bits(present, Uint::load(&hits.slot[i]), Uint(0U));
  }

  PARRAY_INLINE SphereShape<L> spheres(const Uint& slot) const {
    constexpr int width_bits = __builtin_ctz(B::count);
    const Uint lane = slot & Uint(B::count - 1);
    const Uint at = (slot >> width_bits << (width_bits + 2)) + lane;
    const Store* x = scene_.bvh.blocks[0].x;
    return {{L::gather(x, at), L::gather(x + B::count, at), L::gather(x + 2 * B::count, at)},
            L::gather(x + 3 * B::count, at)};
  }

  PARRAY_INLINE CapsuleShape<L> capsules(const Uint& slot) const {
    constexpr int width_bits = __builtin_ctz(B::count);
    const Uint lane = slot & Uint(B::count - 1);
    constexpr auto block_size =
        static_cast<std::uint32_t>(sizeof(CapsuleBlock<Store, B::count>) / sizeof(Store));
    const Uint at = (slot >> width_bits) * Uint(block_size) + lane;
    const Store* x = scene_.capsules.blocks[0].x;
    const auto number = [&](int k) { return L::gather(x + k * B::count, at); };
    return {{number(0), number(1), number(2)}, {number(3), number(4), number(5)}, number(6)};
  }

  /// A vector of hits with the data that scattering needs.
  struct Meeting {
    Vec3<L> incoming;
    SphereShape<L>
        sphere;      ///< the sphere met; of a capsule, a sphere in it that touches the met point
    Vec3<L> normal;  ///< outward
    Vec3<L> m;       ///< normal on the path's side
    MaskOf<L> leaving;
    RandomAddress<Uint> random;
  };

  PARRAY_INLINE Meeting meet(const Hits<Real>& hits, std::uint32_t i, std::uint32_t present) const {
    const Ray<L> ray(hits.origin.template load<L>(i), hits.direction.template load<L>(i),
                     L::load(&hits.inverse_square[i]));
    const Uint slot = slots(hits, i, present);
    SphereShape<L> sphere = spheres(Capsules ? slot_among_spheres(slot) : slot);
    const RandomAddress<Uint> random = random_of(hits, i, present);
    if constexpr (InsideStack) {
      const MaskOf<L> leaving = L::load(&hits.side[i]) > L(Real(0));
      const MaskOf<L> from_itself = L::load(&hits.side[i]) > L(Real(1));
      Vec3<L> normal = normal_at(ray, sphere, leaving);
      if (any(from_itself)) {
        const Vec3<L> across = normalize(sphere.radius * hits.old_normal.template load<L>(i) +
                                         L::load(&hits.t[i]) * ray.direction);
        normal = select(from_itself, across, normal);
      }
      if constexpr (Capsules) meet_capsules(ray, slot, leaving, sphere, normal);
      return {ray.direction, sphere, normal, select(leaving, -normal, normal), leaving, random};
    } else {
      const MaskOf<L> leaving = L(Real(0)) > L(Real(0));
      Vec3<L> normal = normal_entering(ray, sphere);
      if constexpr (Capsules) meet_capsules(ray, slot, leaving, sphere, normal);
      return {ray.direction, sphere, normal, normal, leaving, random};
    }
  }

  /// Returns the numbers of capsule slots among capsules. Bit 31 is set for slots of spheres.
  PARRAY_INLINE Uint slot_among_capsules(const Uint& slot) const {
    return slot + Uint(0U - scene_.capsules.first_slot);
  }

  /// Returns slots of spheres as they are, and 0 for slots of capsules.
  PARRAY_INLINE Uint slot_among_spheres(const Uint& slot) const {
    return slot & ((slot_among_capsules(slot) >> 31) * Uint(0xFFFFFFFFU));
  }

  /// Replaces the sphere and the normal of a Meeting in the lanes of capsules.
  PARRAY_INLINE void meet_capsules(const Ray<L>& ray, const Uint& slot, const MaskOf<L>& leaving,
                                   SphereShape<L>& sphere, Vec3<L>& normal) const {
    const Uint number = slot_among_capsules(slot);
    const MaskOf<L> met = equal(number >> 31, Uint(0U));
    if (!any(met)) return;
    const CapsuleShape<L> capsule = capsules(select(met, number, Uint(0U)));
    const SurfacePoint<L> on = surface_point(ray, capsule, leaving);
    normal = select(met, on.normal, normal);
    sphere.center = select(met, on.center, sphere.center);
    sphere.radius = select(met, on.radius, sphere.radius);
  }

  PARRAY_INLINE RandomAddress<Uint> random_of(const Hits<Real>& hits, std::uint32_t i,
                                              std::uint32_t present) const {
    const Uint sample = select_bits(present, Uint::load(&hits.sample[i]), Uint(0U));
    return {scene_.seed, Uint::gather(space_.pixel.at, sample),
            Uint::gather(space_.sample_number, sample), scene_.sampler};
  }

  /// Returns column `K` of the materials' rows (see MaterialParameters).
  template <int K>
  PARRAY_INLINE L material_column(const Uint& row) const {
    static_assert(sizeof(MaterialParameters<Real>) == 8 * sizeof(Real));
    return L::gather(reinterpret_cast<const Real*>(scene_.surfaces) + K, row);
  }

  PARRAY_INLINE Vec3<L> albedo(const Uint& row) const {
    return {material_column<0>(row), material_column<1>(row), material_column<2>(row)};
  }

  /// Continues the paths in the lanes of `going` with a new direction from the surface.
  PARRAY_INLINE void go_on(const Hits<Real>& hits, std::uint32_t i, std::uint32_t going,
                           const Meeting& at, const Vec3<L>& direction, const Vec3<L>& throughput) {
    Paths<Real>& to = space_.paths;
    const std::uint32_t n = to.count;
    to.origin.compress(n, going, at.sphere.center + at.sphere.radius * at.normal);
    to.direction.compress(n, going, direction);
    to.throughput.compress(n, going, throughput);
    compress_store(&to.sample[n], going, Uint::load(&hits.sample[i]));
    compress_store(&to.surface[n], going, Uint::load(&hits.slot[i]));
    if constexpr (InsideStack) {
      to.normal.compress(n, going, at.normal);
      compress_store(&to.inside[n], going, Uint::load(&hits.inside[i]));
    }
    to.count = n + static_cast<std::uint32_t>(__builtin_popcount(going));
  }

  /// Returns the first number of each material's row; that of material 0 for lanes without a hit.
  PARRAY_INLINE static Uint row_of(const Hits<Real>& hits, std::uint32_t i, std::uint32_t present) {
    return select_bits(present, Uint::load(&hits.material[i]), Uint(0U)) << 3;
  }

  void scatter_all_diffuse(std::uint32_t bounce) {
    const Hits<Real>& hits = space_.hits[static_cast<int>(MaterialType::diffuse)];
    for (std::uint32_t i = 0; i < hits.count; i += lanes) {
      const std::uint32_t present = first_bits(hits.count - i);
      const Meeting at = meet(hits, i, present);
      const auto u = at.random.template at<L>(bounce, Purpose::scatter);
      const Vec3<L> direction = scatter_diffuse(at.m, u);
      const Vec3<L> throughput =
          hits.throughput.template load<L>(i) * albedo(row_of(hits, i, present));
      go_on(hits, i, present, at, direction, throughput);
    }
  }

  void scatter_all_metal(std::uint32_t bounce) {
    const Hits<Real>& hits = space_.hits[static_cast<int>(MaterialType::metal)];
    for (std::uint32_t i = 0; i < hits.count; i += lanes) {
      const std::uint32_t present = first_bits(hits.count - i);
      const Uint row = row_of(hits, i, present);
      const Meeting at = meet(hits, i, present);
      const Vec3<L> throughput = hits.throughput.template load<L>(i) * albedo(row);
      if (!scene_.features.fuzz) {
        go_on(hits, i, present, at, scatter_mirror(at.incoming, at.m), throughput);
        continue;
      }
      const auto u = at.random.template at<L>(bounce, Purpose::scatter);
      const auto r = at.random.template at<L>(bounce, Purpose::fuzz);
      const auto metal = scatter_metal(material_column<3>(row), at.incoming, at.m, u, r);
      const std::uint32_t absorbed = bits_of(metal.mask) & present;
      go_on(hits, i, present & ~absorbed, at, metal.direction, throughput);
      if constexpr (InsideStack) {
        for (std::uint32_t left = absorbed; left != 0; left &= left - 1) {
          space_.inside.release(hits.inside[i + static_cast<std::uint32_t>(__builtin_ctz(left))]);
        }
      }
    }
  }

  void scatter_all_dielectric(std::uint32_t bounce) {
    const Hits<Real>& hits = space_.hits[static_cast<int>(MaterialType::dielectric)];
    for (std::uint32_t i = 0; i < hits.count; i += lanes) {
      const std::uint32_t present = first_bits(hits.count - i);
      const Uint row = row_of(hits, i, present);
      const Meeting at = meet(hits, i, present);
      const auto u = at.random.template at<L>(bounce, Purpose::scatter);
      MaterialParameters<L> surface;
      surface.ior = material_column<4>(row);
      surface.inverse_ior = material_column<5>(row);
      surface.normal_reflectance = material_column<6>(row);
      const auto glass = scatter_dielectric(surface, at.incoming, at.m, at.leaving, u);
      Vec3<L> direction = glass.direction;
      std::uint32_t straight = 0;
      if (crossings_remain_) {
        straight = crossing_lanes(hits, i, present);
        direction.x = select_bits(straight, at.incoming.x, direction.x);
        direction.y = select_bits(straight, at.incoming.y, direction.y);
        direction.z = select_bits(straight, at.incoming.z, direction.z);
      }
      const std::uint32_t n = space_.paths.count;
      go_on(hits, i, present, at, direction, hits.throughput.template load<L>(i));
      cross(hits, i, present, (bits_of(glass.mask) & present) | straight, n);
    }
  }

  /// Moves the hits i, i + 1 ... in the lanes `crossing` through their surface: changes their list
  /// of shapes. go_on() has made the lanes `going` paths n, n + 1 ...
  PARRAY_INLINE void cross(const Hits<Real>& hits, std::uint32_t i, std::uint32_t going,
                           std::uint32_t crossing, std::uint32_t n) {
    for (; crossing != 0; crossing &= crossing - 1) {
      const auto k = static_cast<std::uint32_t>(__builtin_ctz(crossing));
      const std::uint32_t before = going & ((1U << k) - 1);
      const std::uint32_t slot = hits.slot[i + k];
      std::uint32_t& inside =
          space_.paths.inside[n + static_cast<std::uint32_t>(__builtin_popcount(before))];
      inside = hits.side[i + k] > 0 ? space_.inside.remove(inside, slot)
                                    : space_.inside.push(inside, slot);
    }
  }

  const SceneTables& scene_;
  Space& space_;
  bool crossings_remain_ = false;  ///< hits of glass may lie inside another body of the same glass
};

}  // namespace parray::trace
