#pragma once

#include <cstdint>
#include <limits>

#include "common/math/lanes.h"

/// Groups of rays that traverse a tree together, and the distances of rays to the planes of its
/// boxes. The rays of a group take turns: each makes one step, then each makes the next one.
namespace parray::trace {

/// Rays of a group that wait for the same kind of step, each with the child that it enters next.
struct Waiting {
  static constexpr std::uint32_t most = 64;  ///< most rays of a group

  std::uint32_t ray[most];    ///< positions of the rays in their group
  std::uint32_t child[most];  ///< numbers of nodes or blocks
  std::uint32_t count = 0;

  /// Adds ray `k` of the group with the child `next` if `waits` is 1; 0 leaves it out. `count` must
  /// be below `most` in both cases.
  PARRAY_INLINE void add(std::uint32_t k, std::uint32_t next, std::uint32_t waits) {
    ray[count] = k;
    child[count] = next;
    count += waits;
  }
};

/// Rays with directions of the same signs, and the indices into the planes of a node that follow
/// from the signs. A node has the low and the high planes along x, then those along y and z,
/// `Width` planes each.
template <std::uint32_t Width>
struct RayGroup {
  const std::uint32_t* ray;  ///< numbers of the rays in the columns
  std::uint32_t count;
  std::uint32_t octant;  ///< bits 0, 1 and 2: the directions are negative along x, y and z
  std::uint32_t near_x, near_y, near_z;  ///< indices of the first planes on the near side

  PARRAY_INLINE RayGroup(const std::uint32_t* rays, std::uint32_t size, std::uint32_t signs)
      : ray(rays),
        count(size),
        octant(signs),
        near_x((signs & 1) * Width),
        near_y(2 * Width + (signs >> 1 & 1) * Width),
        near_z(4 * Width + (signs >> 2 & 1) * Width) {}
};

/// A ray's distances to planes: for a plane across an axis, plane x inverse + shift. `near` and
/// `far` are the shifts for planes on the ray's near and far side. `margin` moves them so that near
/// planes appear nearer and far planes farther (see wide_bvh.h). Rounding, of fused products or of
/// others, moves a plane by at most 4 roundoffs of its coordinate and the origin's. That is a part
/// of the amount by which boxes and margins grow.
///
/// A ray that runs along the planes is turned a little, until |inverse| is `steepest`. Let R be the
/// largest absolute coordinate of its origin and M that of a box. In single precision the new slope
/// is 2^-102 max(R, 2^-24). A direction has a length of about 1, so the distance of the box is at
/// most 4 (R + M). There the ray is off by 2^-100 max(R, 2^-24) (R + M). That is far below a
/// roundoff of R + M, because R is far below 2^76. Shifts stay below 2^103. If plane x inverse
/// overflows, the plane is so far from the origin that the sign of infinity tells its side.
template <typename B>
struct Slab {
  using Store = decltype(RealTraits<B>::unit_roundoff + 0);

  B inverse, near, far;
  MaskOf<B> down;

  PARRAY_INLINE Slab(const B& origin, const B& direction, const B& margin, const B& steepest)
      : inverse(B(Store(1)) / direction), down(inverse < B(Store(0))) {
    inverse = min_of(max_of(inverse, -steepest), steepest);
    const B shift = select(down, -margin, margin);
    near = -(origin + shift) * inverse;
    far = -(origin - shift) * inverse;
  }

  /// Returns the largest |inverse| to allow, which is finite, for rays with this largest absolute
  /// coordinate of their origins.
  static PARRAY_INLINE B steepest(const B& reach) {
    constexpr Store roundoff = RealTraits<Store>::unit_roundoff;
    constexpr Store most = roundoff / std::numeric_limits<Store>::min();
    return B(most) / max_of(reach, B(roundoff));  // reach may be -0 or NaN
  }
};

}  // namespace parray::trace
