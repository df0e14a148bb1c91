#pragma once

#include <cmath>

#include "common/math/vec.h"
#include "tests/support/rooms.h"

namespace parray::test {

/// Arithmetic with 113 bits, the oracle of the numeric tests. For inputs in single and double
/// precision it is practically exact.
#if __LDBL_MANT_DIG__ == 113
using Quad = long double;
#else
__extension__ typedef __float128 Quad;  // NOLINT(modernize-use-using): only a typedef can be marked
#endif
using QuadVec = Vec3<Quad>;

/// Returns the square root to the last bits, by two Newton steps from the 64-bit root. Returns 0
/// for x <= 0.
inline Quad quad_sqrt(Quad x) {
  if (!(x > 0)) return 0;
  Quad root = static_cast<Quad>(std::sqrt(static_cast<long double>(x)));
  for (int step = 0; step < 2; ++step) root = (root + x / root) / 2;
  return root;
}

inline Quad quad_abs(Quad x) { return x < 0 ? -x : x; }
inline Quad quad_length(const QuadVec& v) { return quad_sqrt(dot(v, v)); }

template <typename Real>
QuadVec exact(const Vec3<Real>& v) {
  return vec_cast<Quad>(v);
}

}  // namespace parray::test

namespace parray::math {

/// The tracer's templates with 113 bits: an oracle that shares only these templates with the
/// tracer.
template <>
struct RealTraits<test::Quad> {
  static constexpr test::Quad unit_roundoff = test::Quad(0x1p-113L);
  static constexpr test::Quad infinity = __builtin_inff();
  static constexpr int sine_terms = 16;
  static test::Quad sqrt(test::Quad x) { return test::quad_sqrt(x); }
};

}  // namespace parray::math
