#pragma once

#include <cmath>
#include <cstdint>
#include <random>

#include "common/math/vec.h"
#include "tests/support/rooms.h"

namespace parray::test {

/// Seeded random values for tests. Unlike the standard distributions, they are the same on every
/// machine.
class Dice {
 public:
  explicit Dice(std::uint64_t seed) : engine_(seed) {}

  std::uint64_t bits() { return engine_(); }
  /// Returns a number from 0 to n - 1; n > 0.
  std::uint64_t below(std::uint64_t n) { return engine_() % n; }
  /// Does the same with 32 bits.
  std::uint32_t below32(std::uint32_t n) { return static_cast<std::uint32_t>(below(n)); }
  bool one_in(std::uint64_t n) { return below(n) == 0; }
  /// Returns a number in [0, 1) of 53 bits.
  double unit() { return static_cast<double>(engine_() >> 11) * 0x1p-53; }
  double between(double low, double high) { return low + (high - low) * unit(); }
  /// Returns 10^x with x uniform in [low, high).
  double ten_to(double low, double high) { return std::pow(10, between(low, high)); }
  double sign() { return one_in(2) ? 1 : -1; }
  /// Returns a uniform point of the cube [-reach, reach)^3.
  Vec3d in_cube(double reach) {
    const double x = between(-reach, reach);
    const double y = between(-reach, reach);
    return {x, y, between(-reach, reach)};
  }
  /// Returns a uniform unit vector, by rejection from the cube.
  Vec3d direction() {
    for (;;) {
      const Vec3d v = in_cube(1);
      const double square = dot(v, v);
      if (square > 0.01 && square <= 1) return (1 / std::sqrt(square)) * v;
    }
  }
  /// Returns a unit vector at right angles to the unit vector `axis`.
  Vec3d across(const Vec3d& axis) {
    for (;;) {
      const Vec3d v = cross(axis, direction());
      if (dot(v, v) > 0.01) return normalize(v);
    }
  }

 private:
  std::mt19937_64 engine_;
};

}  // namespace parray::test
