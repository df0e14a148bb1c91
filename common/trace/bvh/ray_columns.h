#pragma once

#include <cstdint>
#include <type_traits>

#include "common/math/vec.h"
#include "common/trace/inside_lists.h"

/// Rays in the form that traversal reads, column by column, so that lanes load and store them, and
/// the scratch memory of traversal. Columns have room for a whole vector beyond the last ray.
/// Nothing is initialised.
namespace parray::trace {

inline constexpr std::uint32_t most_rays = 1024;  ///< most rays that are traced together
inline constexpr std::uint32_t column_size = most_rays + 16;  ///< whole vectors are read

/// One number of each ray.
template <typename T>
struct alignas(64) Column {
  T at[column_size];

  PARRAY_INLINE T& operator[](std::uint32_t i) { return at[i]; }
  PARRAY_INLINE const T& operator[](std::uint32_t i) const { return at[i]; }
};

/// One vector of each ray.
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
  /// Stores the lanes whose bits in `set` are set, one after the other, as rays i, i + 1 ...
  template <typename L>
  PARRAY_INLINE void compress(std::uint32_t i, std::uint32_t set, const Vec3<L>& v) {
    compress_store(&x[i], set, v.x);
    compress_store(&y[i], set, v.y);
    compress_store(&z[i], set, v.z);
  }
};

/// The start of each ray, and the shapes that it cannot enter.
template <typename Real>
struct RayColumns {
  std::uint32_t count;  ///< of rays, at most most_rays
  VecColumns<Real> origin, direction;
  Column<std::uint32_t> surface;  ///< slot of the shape that the ray stands on, or no_shape
  // Only used if rays can be inside a shape.
  VecColumns<Real> normal;       ///< outward normal of the surface
  Column<std::uint32_t> inside;  ///< first link of its list in InsideLists
};

/// The data of each ray for screening spheres: see screen.h.
template <typename Store>
struct ScreenColumns {
  VecColumns<Store> origin, direction;
  Column<Store> inverse_square;
  Column<Store> margin;  ///< amount that is added to radii
  /// A sphere with a smaller dot(centre - origin, direction) lies behind the ray.
  Column<Store> behind;
};

/// The spheres of a block that pass the screen.
template <typename Store>
struct Candidates {
  static constexpr int most = 16;
  alignas(64) Store x[most], y[most], z[most], radius[most];
  std::uint32_t slot[most];
};

/// The remaining data of each ray for finding its next surface, and the result.
template <typename Real, typename Store>
struct Queries {
  Column<Real> inverse_square;
  /// 1 / direction of the ray, and the amounts that are added to plane / direction for planes of
  /// boxes on the near and on the far side (see Traversal::Slab).
  VecColumns<Store> inverse, near_shift, far_shift;
  Column<std::uint32_t> octant;    ///< bit set: the direction is < 0 on that axis
  Column<std::uint32_t> numbers;   ///< list of the rays of one octant
  Column<std::uint32_t> excluded;  ///< bits of those of 32 open spheres that it cannot enter
  Column<Real> t;                  ///< nearest crossing so far
  Column<std::uint32_t> slot;      ///< slot of the shape of that crossing, or no_shape
  Column<std::uint32_t> leaving;   ///< 1: that crossing leads out of the shape; otherwise 0
  struct None {};
  std::conditional_t<sizeof(Real) == sizeof(Store), None, ScreenColumns<Store>> screen;
};

/// The scratch memory of traversal.
template <typename Real, typename Store>
struct TraversalSpace {
  Queries<Real, Store> queries;
  InsideLists inside;
  /// Most rays of a beam (beam_search.h) in the next search; 0: no beams. With beams, no ray may
  /// stand on a surface or be inside a shape.
  std::uint32_t beam = 0;
  Candidates<Store> candidates;
  /// Number of stack entries. Rays traverse in groups; the pending children of a ray lie one after
  /// the other.
  static constexpr std::uint32_t stack_entries = 16384;
  alignas(64) Store stack_t[stack_entries];
  alignas(64) std::uint32_t stack_child[stack_entries];
};

}  // namespace parray::trace
