#pragma once

#include <cstdint>

#include "common/trace/bvh/bvh_view.h"
#include "common/trace/bvh/ray_columns.h"

/// Selects the spheres of a block that a ray may enter. It computes in the type of the stored
/// spheres, where paths have a wider type. That tests many lanes at once, and it never misses a
/// sphere that the ray enters.
///
/// Let u be the roundoff of the stored type. Let X be the sum of the largest coordinates of the
/// ray's origin and of the tree's spheres, radii included. Four values are rounded: the ray, the
/// vector to the centre, its foot on the ray, and the difference of both. They move the
/// perpendicular by at most 2, 2, 6 and 4 roundoffs of that vector's length. The length is less
/// than 2 X, so the total is 28 u X. Radii grow by 32 u X. The remaining 4 u X exceed the loss by
/// squaring, 7 u / 2 of a radius below X. The error of the foot is below 20 u X. Radii are above
/// 1e-15 and lengths below 1e15 (limits.h), so their squares are finite and lose no bits.
namespace parray::trace {

/// Prepares rays i, i + 1, ... of a vector. `reach` holds the largest coordinates of their origins,
/// `extent` that of the tree's spheres.
template <typename B>
PARRAY_INLINE void prepare_screen(ScreenColumns<typename B::Scalar>& to, std::uint32_t i,
                                  const Vec3<B>& origin, const Vec3<B>& direction, const B& reach,
                                  typename B::Scalar extent) {
  using Store = typename B::Scalar;
  constexpr Store share = Store(32) * RealTraits<Store>::unit_roundoff;
  const B square = dot(direction, direction);
  const B margin = B(share) * (reach + B(extent));
  to.origin.store(i, origin);
  to.direction.store(i, direction);
  (B(Store(1)) / square).store(&to.inverse_square[i]);
  margin.store(&to.margin[i]);
  (B(Store(-2)) * margin * max_of(square, B(Store(1)))).store(&to.behind[i]);
}

/// Returns the lanes of the spheres that ray `i` may enter, as bits; never lanes without a sphere
/// (NaN).
template <typename B, int W>
PARRAY_INLINE std::uint32_t may_enter(const ScreenColumns<typename B::Scalar>& rays,
                                      std::uint32_t i,
                                      const SphereBlock<typename B::Scalar, W>& block) {
  const B dx(rays.direction.x[i]);
  const B dy(rays.direction.y[i]);
  const B dz(rays.direction.z[i]);
  const B x = B::load(block.x) - B(rays.origin.x[i]);
  const B y = B::load(block.y) - B(rays.origin.y[i]);
  const B z = B::load(block.z) - B(rays.origin.z[i]);
  const B along = multiply_add(x, dx, multiply_add(y, dy, z * dz));
  const B back = -along * B(rays.inverse_square[i]);
  const B off_x = multiply_add(back, dx, x);
  const B off_y = multiply_add(back, dy, y);
  const B off_z = multiply_add(back, dz, z);
  const B square = multiply_add(off_x, off_x, multiply_add(off_y, off_y, off_z * off_z));
  const B radius = B::load(block.radius) + B(rays.margin[i]);
  return bits_of((square <= radius * radius) & (B(rays.behind[i]) <= along));
}

}  // namespace parray::trace
