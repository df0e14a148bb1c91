#pragma once

#include <cstdint>

#include "common/trace/inside_lists.h"
#include "common/trace/kernel_scene.h"

/// The scratch memory of a batch: what is known of each path, column by column, so that lanes load
/// and store it. Columns have room for a whole vector beyond the last path. Nothing is initialised.
namespace parray {

inline constexpr std::uint32_t column_size = SampleBatch::room;

template <typename T>
struct alignas(64) Column {
  T at[column_size];

  PARRAY_INLINE T& operator[](std::uint32_t i) { return at[i]; }
  PARRAY_INLINE const T& operator[](std::uint32_t i) const { return at[i]; }
};

template <typename T>
struct VecColumns {
  Column<T> x, y, z;

  PARRAY_INLINE Vec3<T> operator[](std::uint32_t i) const { return {x[i], y[i], z[i]}; }
  PARRAY_INLINE void set(std::uint32_t i, const Vec3<T>& v) {
    x[i] = v.x;
    y[i] = v.y;
    z[i] = v.z;
  }
  template <typename L>
  PARRAY_INLINE Vec3<L> load(std::uint32_t i) const {
    return {L::load(&x[i]), L::load(&y[i]), L::load(&z[i])};
  }
  template <typename L>
  PARRAY_INLINE void store(std::uint32_t i, const Vec3<L>& v) {
    v.x.store(&x[i]);
    v.y.store(&y[i]);
    v.z.store(&z[i]);
  }
  /// Stores the lanes whose bit is set, one path after the other.
  template <typename L>
  PARRAY_INLINE void compress(std::uint32_t i, std::uint32_t set, const Vec3<L>& v) {
    compress_store(&x[i], set, v.x);
    compress_store(&y[i], set, v.y);
    compress_store(&z[i], set, v.z);
  }
};

/// Paths that go on, each with its next ray.
template <typename Real>
struct Paths {
  std::uint32_t count;
  VecColumns<Real> origin, direction, throughput;
  Column<std::uint32_t> sample;   ///< number in the batch
  Column<std::uint32_t> surface;  ///< slot that the path stands on, or no_sphere
  // Only where paths can be inside something.
  VecColumns<Real> normal;       ///< outward, of the surface
  Column<std::uint32_t> inside;  ///< head in InsideLists
};

/// Paths that have met a surface of one type of material, or the sky.
template <typename Real>
struct Hits {
  std::uint32_t count;
  VecColumns<Real> origin, direction, throughput;
  Column<Real> inverse_square;
  Column<std::uint32_t> sample, slot, material;
  // Only where paths can be inside something.
  Column<Real> side;  ///< 0: into the sphere, 1: out of it, 2: the same from its own surface
  Column<std::uint32_t> inside;
  // Only of those on side 2.
  VecColumns<Real> old_normal;  ///< of the surface that the path stood on
  Column<Real> t;
};

/// What finding the next surface needs to know of each ray, and what it finds.
template <typename Real, typename Store>
struct Queries {
  Column<Real> inverse_square;
  /// Of the ray: 1 / direction, and the origin moved by its share of the rounding, so that box
  /// planes on the near side appear nearer and those on the far side farther (see sphere_tables.h).
  VecColumns<Store> inverse, near_origin, far_origin;
  /// Places in a node: of the nearer planes, of the children's order.
  Column<std::uint32_t> near_x, near_y, near_z, order;
  Column<std::uint32_t> barred;  ///< which of some 32 open spheres it cannot enter, as bits
  Column<Real> t;                ///< nearest crossing so far
  Column<std::uint32_t> slot;    ///< its sphere, or no_sphere
  Column<std::uint32_t> leaving;
};

template <typename Real, typename Store>
struct Workspace {
  Paths<Real> paths;
  Queries<Real, Store> queries;
  static constexpr std::uint32_t sky = 3;
  Hits<Real> hits[4];                            ///< by MaterialType, then those of the sky
  Column<std::uint32_t> pixel;                   ///< of each sample of the batch
  const std::uint32_t* sample_number = nullptr;  ///< of each: the batch's
  InsideLists inside;
  /// Rays traverse in groups; a ray's pending children lie one after the other.
  static constexpr std::uint32_t stack_entries = 16384;
  alignas(64) Store stack_t[stack_entries];
  alignas(64) std::uint32_t stack_child[stack_entries];
};

/// The spheres that a point of the lens lies in, as a list in `inside`.
template <typename Real, typename Store, int W>
PARRAY_INLINE std::uint32_t inside_at(const KernelScene<Real, Store, W>& scene,
                                      const Vec3<Real>& origin, InsideLists& inside) {
  std::uint32_t head = InsideLists::none;
  for (std::uint32_t k = 0; k < scene.around_lens_count; ++k) {
    const std::uint32_t slot = scene.around_lens[k];
    const auto sphere = sphere_at<Real>(scene.blocks, slot);
    const Vec3<Real> from_center = origin - sphere.center;
    if (dot(from_center, from_center) < sphere.radius * sphere.radius) {
      head = inside.push(head, slot);
    }
  }
  return head;
}

}  // namespace parray
