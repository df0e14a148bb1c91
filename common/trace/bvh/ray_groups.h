#pragma once

#include <cstdint>
#include <limits>

#include "common/math/lanes.h"

/// Rays that go through a tree side by side, taking their steps by turns, and their distances to
/// the planes of its boxes.
namespace parray {

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
/// nearer and the second farther (see wide_bvh.h). Where a shift overflows or is not a number,
/// because the ray runs along the planes, the axis constrains nothing. Rounding, of products that
/// are fused or not, moves a plane by 4 roundoffs of its coordinate and the origin's at most: a
/// part of what boxes and margins are grown by.
template <typename B>
struct Slab {
  using Store = typename B::Scalar;

  B inverse, near, far;
  MaskOf<B> down;

  PARRAY_INLINE Slab(const B& origin, const B& direction, const B& margin)
      : inverse(B(Store(1)) / direction), down(inverse < B(Store(0))) {
    const B shift = select(down, -margin, margin);
    near = -(origin + shift) * inverse;
    far = -(origin - shift) * inverse;
    const B most(RealTraits<Store>::unit_roundoff / std::numeric_limits<Store>::min());
    const auto sound = (max_of(near, -near) <= most) & (max_of(far, -far) <= most);
    inverse = select(sound, inverse, B(Store(0)));
    near = select(sound, near, B(-RealTraits<Store>::infinity));
    far = select(sound, far, B(RealTraits<Store>::infinity));
  }
};

}  // namespace parray
