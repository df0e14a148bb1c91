#pragma once

#include <cstdint>

#include "common/trace/bvh/bvh_view.h"
#include "common/trace/bvh/ray_columns.h"

/// Selects the spheres of a block that a ray may enter from outside: those that the line of the ray
/// meets ahead of the origin. Serves the precision `mixed`, which stores spheres in a narrower type
/// than that of the paths. The screen computes in the stored type, which tests more spheres at
/// once. It never misses a sphere that the ray enters. It may select others, which the exact test
/// drops.
///
/// Let u be the unit roundoff of the stored type. Let X be the largest absolute coordinate of the
/// ray's origin, plus that of the tree's spheres, radii included. The foot is the point of the line
/// nearest to the centre, and the perpendicular is the vector from the foot to the centre. Four
/// values are rounded: the ray, the vector from its origin to the centre, the vector from its
/// origin to the foot, and the difference of these two vectors, which is the perpendicular. Each
/// rounding moves the perpendicular: by at most 2, 2, 6 and 4 roundoffs of the distance from the
/// origin to the centre. That distance is less than 2 X, so the total is at most 28 u X.
///
/// Radii grow by 32 u X. The other 4 u X are for the squares of perpendicular and radius, whose
/// rounding counts like 7 u / 2 of the radius, which is below X. The position of the foot along the
/// ray is wrong by less than 20 u X; `behind` allows 64 u X. Radii are above 1e-15 and lengths
/// below 1e15 (limits.h), so their squares neither overflow nor underflow.
namespace parray::trace {

/// Prepares rays i, i + 1, ..., one for each lane. `reach` holds the largest absolute coordinate of
/// the origin of each. `extent` is the largest one of the tree's spheres, radii included.
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

/// Returns a bit for each lane of `block`, set if ray `i` may enter the sphere in this lane. The
/// bit of a lane without a sphere (NaN) is 0.
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
