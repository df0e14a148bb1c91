#pragma once

#include <cstdint>
#include <limits>

#include "common/math/lanes.h"

/// Groups of rays that traverse a tree together, each taking its steps in turn, and their distances
/// to the planes of its boxes.
namespace parray::trace {

/// Rays of a group that wait for the same kind of step, each with the child that it enters next.
struct Waiting {
  static constexpr std::uint32_t most = 64;

  std::uint32_t ray[most];
  std::uint32_t child[most];
  std::uint32_t count = 0;

  /// Adds a ray if `waits` is 1; 0 leaves it out.
  PARRAY_INLINE void add(std::uint32_t k, std::uint32_t next, std::uint32_t waits) {
    ray[count] = k;
    child[count] = next;
    count += waits;
  }
};

/// Rays with directions of the same signs, and the places in a node that follow from the signs.
template <std::uint32_t Width>
struct RayGroup {
  const std::uint32_t* ray;  ///< numbers of the rays in the columns
  std::uint32_t count;
  std::uint32_t octant;
  std::uint32_t near_x, near_y, near_z;  ///< places of the planes on the near side

  PARRAY_INLINE RayGroup(const std::uint32_t* rays, std::uint32_t size, std::uint32_t signs)
      : ray(rays),
        count(size),
        octant(signs),
        near_x((signs & 1) * Width),
        near_y(2 * Width + (signs >> 1 & 1) * Width),
        near_z(4 * Width + (signs >> 2 & 1) * Width) {}
};

/// A ray's distance to a plane across an axis is plane x inverse + shift. `near` and `far` are
/// the shifts for planes on its near and far side, moved by `margin` so that the first appear
/// nearer and the second farther (see wide_bvh.h). Rounding, of products that are fused or not,
/// moves a plane by 4 roundoffs of its coordinate and the origin's at most: a part of what boxes
/// and margins are grown by.
///
/// A ray that runs along the planes is turned a little, until `inverse` is `steepest`. With R for
/// the largest coordinate of its origin and M for that of a box, in single precision, its new slope
/// is 2^-102 max(R, 2^-24). A direction is about as long as 1, so the box is at a distance of
/// 4 (R + M) at most, and the ray is off by 2^-100 max(R, 2^-24) (R + M) there: no part of a
/// roundoff of R + M, R being far below 2^76. Shifts stay below 2^103. Where plane x inverse
/// overflows, the plane is so far from the origin that the sign of infinity says on which side.
template <typename B>
struct Slab {
  using Store = typename B::Scalar;

  B inverse, near, far;
  MaskOf<B> down;

  PARRAY_INLINE Slab(const B& origin, const B& direction, const B& margin, const B& steepest)
      : inverse(B(Store(1)) / direction), down(inverse < B(Store(0))) {
    inverse = min_of(max_of(inverse, -steepest), steepest);
    const B shift = select(down, -margin, margin);
    near = -(origin + shift) * inverse;
    far = -(origin - shift) * inverse;
  }

  /// Returns the largest |inverse|, which is finite, for rays with this largest coordinate of their
  /// origins.
  static PARRAY_INLINE B steepest(const B& reach) {
    constexpr Store roundoff = RealTraits<Store>::unit_roundoff;
    constexpr Store most = roundoff / std::numeric_limits<Store>::min();
    return B(most) / max_of(reach, B(roundoff));  // reach may be -0 or NaN
  }
};

}  // namespace parray::trace
