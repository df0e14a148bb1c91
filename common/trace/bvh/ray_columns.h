#pragma once

#include <cstdint>
#include <type_traits>

#include "common/math/vec.h"
#include "common/trace/inside_lists.h"

/// Rays as traversal reads them, column by column, so that lanes load and store them, and its
/// scratch memory. Columns have room for a whole vector beyond the last ray. Nothing is
/// initialised.
namespace parray::trace {

inline constexpr std::uint32_t most_rays = 1024;              ///< that are traced side by side
inline constexpr std::uint32_t column_size = most_rays + 16;  ///< whole vectors are read

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
  /// Stores the lanes whose bit is set, one ray after the other.
  template <typename L>
  PARRAY_INLINE void compress(std::uint32_t i, std::uint32_t set, const Vec3<L>& v) {
    compress_store(&x[i], set, v.x);
    compress_store(&y[i], set, v.y);
    compress_store(&z[i], set, v.z);
  }
};

/// Where each ray begins, and which spheres it cannot enter.
template <typename Real>
struct RayColumns {
  std::uint32_t count;
  VecColumns<Real> origin, direction;
  Column<std::uint32_t> surface;  ///< slot that the ray stands on, or no_sphere
  // Only where rays can be inside something.
  VecColumns<Real> normal;       ///< outward, of the surface
  Column<std::uint32_t> inside;  ///< head in InsideLists
};

/// What screening spheres needs to know of each ray: see screen.h.
template <typename Store>
struct ScreenColumns {
  VecColumns<Store> origin, direction;
  Column<Store> inverse_square;
  Column<Store> margin;  ///< what radii grow by
  Column<Store> behind;  ///< centres whose vector times the direction is less are behind the ray
};

/// Those spheres of a block that pass.
template <typename Store>
struct Candidates {
  static constexpr int most = 16;
  alignas(64) Store x[most], y[most], z[most], radius[most];
  std::uint32_t slot[most];
};

/// What finding the next surface needs to know of each ray besides, and what it finds.
template <typename Real, typename Store>
struct Queries {
  Column<Real> inverse_square;
  /// Of the ray: 1 / direction, and what plane / direction is moved by for planes of boxes on the
  /// near and on the far side (see Traversal::Slab).
  VecColumns<Store> inverse, near_shift, far_shift;
  Column<std::uint32_t> octant;    ///< bit: the direction is < 0 on that axis
  Column<std::uint32_t> numbers;   ///< of the rays of one octant
  Column<std::uint32_t> excluded;  ///< which of some 32 open spheres it cannot enter, as bits
  Column<Real> t;                  ///< nearest crossing so far
  Column<std::uint32_t> slot;      ///< its sphere, or no_sphere
  Column<std::uint32_t> leaving;
  struct None {};
  std::conditional_t<sizeof(Real) == sizeof(Store), None, ScreenColumns<Store>> screen;
};

template <typename Real, typename Store>
struct TraversalSpace {
  Queries<Real, Store> queries;
  InsideLists inside;
  Candidates<Store> candidates;
  /// Rays traverse in groups; a ray's pending children lie one after the other.
  static constexpr std::uint32_t stack_entries = 16384;
  alignas(64) Store stack_t[stack_entries];
  alignas(64) std::uint32_t stack_child[stack_entries];
};

}  // namespace parray::trace
