#pragma once

#include <cstdint>

#include "common/trace/bvh/bvh_view.h"
#include "common/trace/bvh/ray_columns.h"
#include "common/trace/bvh/ray_groups.h"

/// Functions that load lanes for traversal: of rays, of shapes of a block, and of planes of a node.
/// `L` are lanes of the real type, `B` lanes of the stored type.
namespace parray::trace {

/// Loads columns of the real type as lanes of the stored type.
template <typename B, typename Real>
PARRAY_INLINE Vec3<B> stored_lanes(const VecColumns<Real>& columns, std::uint32_t i) {
  if constexpr (sizeof(Real) == sizeof(typename B::Scalar)) {
    return columns.template load<B>(i);
  } else {
    return {B::narrow(&columns.x[i]), B::narrow(&columns.y[i]), B::narrow(&columns.z[i])};
  }
}

/// Load shapes k, k + 1, ... of a block, or of Candidates.
template <typename L, typename Spheres>
PARRAY_INLINE SphereShape<L> spheres_of(const Spheres& block, std::uint32_t k) {
  return {{L::load(block.x + k), L::load(block.y + k), L::load(block.z + k)},
          L::load(block.radius + k)};
}
template <typename L, typename Store, int W>
PARRAY_INLINE CapsuleShape<L> capsules_of(const CapsuleBlock<Store, W>& block, std::uint32_t k) {
  return {{L::load(block.x + k), L::load(block.y + k), L::load(block.z + k)},
          {L::load(block.half_x + k), L::load(block.half_y + k), L::load(block.half_z + k)},
          L::load(block.radius + k)};
}

/// Loads the planes of a node's children on the near side of a group's rays, or, if `far` is 1, on
/// the far side.
template <typename B, std::uint32_t Width, typename Node>
PARRAY_INLINE Vec3<B> planes_of(const RayGroup<Width>& group, const Node& node, std::uint32_t far) {
  const auto* const planes = node.planes[0][0];
  const std::uint32_t side = far * Width;
  return {B::load(planes + (group.near_x ^ side)), B::load(planes + (group.near_y ^ side)),
          B::load(planes + (group.near_z ^ side))};
}

/// Converts `t`, which has the same distance in every lane, to the stored type without making it
/// smaller.
template <typename B, typename L>
PARRAY_INLINE B bound_of(const L& t) {
  using Store = typename B::Scalar;
  if constexpr (sizeof(typename L::Scalar) == sizeof(Store)) {
    return t;
  } else {
    return B(static_cast<Store>(first_of(t)) * (1 + 4 * RealTraits<Store>::unit_roundoff));
  }
}

/// Returns bit `number` if that is below `Count`, otherwise 0.
template <std::uint32_t Count>
PARRAY_INLINE std::uint32_t bit_below(std::uint32_t number) {
  return static_cast<std::uint32_t>(number < Count) << (number % 32);
}

/// Calls f(i) for every ray `i` that is inside a shape. If `InsideStack` is false, no ray can be
/// inside a shape, and f is never called.
template <typename L, bool InsideStack, typename Real, typename F>
PARRAY_INLINE void each_inside(const RayColumns<Real>& rays, const F& f) {
  using Uint = typename L::Uint;
  for (std::uint32_t i = 0; InsideStack && i < rays.count; i += L::count) {
    const std::uint32_t left = rays.count - i;
    const std::uint32_t present = left < L::count ? (1U << left) - 1U : (1U << L::count) - 1U;
    const auto outside = equal(Uint::load(&rays.inside[i]), Uint(InsideLists::none));
    for (std::uint32_t set = ~bits_of(outside) & present; set != 0; set &= set - 1) {
      f(i + static_cast<std::uint32_t>(__builtin_ctz(set)));
    }
  }
}

}  // namespace parray::trace
