#pragma once

#include <cstdint>

#include "common/math/vec.h"

namespace parray::trace {

/// The number that stands for no shape.
inline constexpr std::uint32_t no_shape = 0xFFFFFFFF;

/// The most surfaces inside bodies of one glass that a path crosses before the next crossing counts
/// as a segment: see inside_stack.h.
inline constexpr std::uint32_t most_crossings = 64;

/// A half-line. `direction` is finite, not zero, and of unit length except for rounding.
template <typename Real>
struct Ray {
  Vec3<Real> origin;
  Vec3<Real> direction;
  Real inverse_square;  ///< 1 / dot(direction, direction)

  PARRAY_INLINE Ray(const Vec3<Real>& o, const Vec3<Real>& d)
      : origin(o), direction(d), inverse_square(Real(1) / dot(d, d)) {}
  /// Makes a ray with a known `inverse_square`.
  PARRAY_INLINE Ray(const Vec3<Real>& o, const Vec3<Real>& d, Real s)
      : origin(o), direction(d), inverse_square(s) {}
};

/// The nearest crossing found so far. If two crossings are equally far, the shape with the lower
/// index wins, in any order of the tests.
template <typename Real>
struct Hit {
  Real t = RealTraits<Real>::infinity;  ///< ray parameter
  std::uint32_t shape = no_shape;
  bool leaving = false;  ///< the ray comes from inside the shape

  /// Returns whether a crossing of shape `other` at `other_t` counts instead of this one.
  [[nodiscard]] bool loses_to(Real other_t, std::uint32_t other) const {
    return other_t < t || (other_t == t && other < shape);
  }
};

}  // namespace parray::trace
