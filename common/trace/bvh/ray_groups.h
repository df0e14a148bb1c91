#pragma once

#include <cstdint>
#include <limits>

#include "common/math/lanes.h"

/// Rays that go through a tree side by side, taking their steps by turns, and their distances to
/// the planes of its boxes.
namespace parray::trace {

/// Rays of a group that wait for a step of one kind, each with the child that it is to enter.
struct Waiting {
  static constexpr std::uint32_t most = 64;

  std::uint32_t ray[most];
  std::uint32_t child[most];
  std::uint32_t count = 0;

  /// `waits`: 1, or 0 for one that does not.
  PARRAY_INLINE void add(std::uint32_t k, std::uint32_t next, std::uint32_t waits) {
    ray[count] = k;
    child[count] = next;
    count += waits;
  }
};

/// Rays whose directions have the same signs, and what follows from these: places in a node.
template <std::uint32_t Width>
struct RayGroup {
  const std::uint32_t* ray;  ///< numbers in the columns
  std::uint32_t count;
  std::uint32_t octant;
  std::uint32_t near_x, near_y, near_z;  ///< of the planes on their near side

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

  /// What |inverse| is at most, for rays with this largest coordinate of their origins: finite.
  static PARRAY_INLINE B steepest(const B& reach) {
    constexpr Store roundoff = RealTraits<Store>::unit_roundoff;
    constexpr Store most = roundoff / std::numeric_limits<Store>::min();
    return B(most) / max_of(reach, B(roundoff));  // reach may be -0 or no number
  }
};

}  // namespace parray::trace
