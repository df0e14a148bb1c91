#pragma once

#include <cmath>
#include <cstddef>
#include <vector>

#include "common/trace/sphere.h"
#include "tests/support/dice.h"
#include "tests/support/rooms.h"

/// Spheres that are difficult for accelerators.
namespace parray::test {

template <typename Real>
using Spheres = std::vector<SphereShape<Real>>;

template <typename Real>
SphereShape<Real> shape(const Vec3d& center, double radius) {
  return {vec_cast<Real>(center), static_cast<Real>(radius)};
}

template <typename Real>
Spheres<Real> scattered(Dice& dice) {
  Spheres<Real> spheres;
  for (int i = 0; i < 300; ++i) {
    spheres.push_back(shape<Real>(dice.in_cube(10), dice.between(0.05, 1)));
  }
  return spheres;
}

template <typename Real>
Spheres<Real> clustered(Dice& dice) {
  Spheres<Real> spheres;
  for (int cluster = 0; cluster < 20; ++cluster) {
    const Vec3d center = dice.in_cube(1000);
    for (int i = 0; i < 15; ++i) {
      spheres.push_back(shape<Real>(center + dice.in_cube(0.3), dice.ten_to(-3, -1)));
    }
  }
  return spheres;
}

/// Makes a ground of radius 1000 and small spheres that stand on it.
template <typename Real>
Spheres<Real> one_weekend(Dice& dice) {
  Spheres<Real> spheres{shape<Real>({0, -1000, 0}, 1000)};
  for (int x = -9; x < 9; ++x) {
    for (int z = -9; z < 9; ++z) {
      spheres.push_back(shape<Real>({x + 0.9 * dice.unit(), 0.2, z + 0.9 * dice.unit()}, 0.2));
    }
  }
  return spheres;
}

/// Makes spheres with radii down to 1/64 of the spacing of single-precision numbers at their
/// centres.
template <typename Real>
Spheres<Real> tiny_far(Dice& dice) {
  Spheres<Real> spheres;
  for (int i = 0; i < 300; ++i) {
    const Vec3d center{1e6 + dice.between(-20, 20), -1e6 + dice.between(-20, 20),
                       dice.between(-2, 2)};
    spheres.push_back(shape<Real>(center, dice.ten_to(-3, 0)));
  }
  return spheres;
}

template <typename Real>
Spheres<Real> concentric(Dice& dice) {
  Spheres<Real> spheres;
  for (int i = 0; i < 300; ++i) spheres.push_back(shape<Real>({1, 2, 3}, dice.ten_to(-3, 3)));
  return spheres;
}

template <typename Real>
Spheres<Real> collinear(Dice& dice) {
  Spheres<Real> spheres;
  for (int i = 0; i < 150; ++i) {
    spheres.push_back(shape<Real>({static_cast<double>(i), 0, 0}, 0.5));
    const double x = dice.between(-100, 100);
    spheres.push_back(shape<Real>({x, x, x}, 0.25));
  }
  return spheres;
}

/// Makes touching spheres on whole numbers, each twice. Rays along the grid hit ties.
template <typename Real>
Spheres<Real> doubled_grid(Dice& dice) {
  Spheres<Real> spheres;
  for (int copy = 0; copy < 2; ++copy) {
    for (int x = 0; x < 12; ++x) {
      for (int y = 0; y < 12; ++y) {
        spheres.push_back(shape<Real>(
            {static_cast<double>(x), static_cast<double>(y), static_cast<double>(dice.below(2))},
            0.5));
      }
    }
  }
  return spheres;
}

/// Makes spheres far from the origin of coordinates at its height, so that a ray may start near 0.
template <typename Real>
Spheres<Real> ring(Dice& dice) {
  Spheres<Real> spheres;
  for (int i = 0; i < 200; ++i) {
    const double x = dice.between(-1, 1);
    const Vec3d around{x, 0, dice.sign() * std::sqrt(1 - x * x)};
    spheres.push_back(shape<Real>(1000 * around + dice.in_cube(0.1), dice.between(0.01, 2)));
  }
  return spheres;
}

template <typename Real>
Spheres<Real> every_size(Dice& dice) {
  Spheres<Real> spheres;
  for (int i = 0; i < 200; ++i) {
    const double size = dice.ten_to(-6, 6);
    spheres.push_back(shape<Real>((dice.ten_to(0, 2) * size) * dice.direction(), size));
  }
  return spheres;
}

template <typename Real>
Spheres<Real> coincident(std::size_t count) {
  return Spheres<Real>(count, shape<Real>({1, 2, 3}, 0.7));
}

/// Makes small spheres on whole numbers, and giants around some of them that touch them at a pole.
/// Rays along the axes hit both at the same distance. Giants come before, among and after the
/// others.
template <typename Real>
Spheres<Real> touching_giants(Dice& dice, std::size_t giants) {
  Spheres<Real> spheres;
  for (int x = 0; x < 8; ++x) {
    for (int y = 0; y < 8; ++y) {
      spheres.push_back(shape<Real>({static_cast<double>(x), static_cast<double>(y), 0}, 0.5));
    }
  }
  for (std::size_t i = 0; i < giants; ++i) {
    Vec3d center = vec_cast<double>(spheres[dice.below(spheres.size())].center);
    const double off = dice.sign() * 63.5;  // radius 64: one pole in common
    (dice.one_in(3) ? center.x : dice.one_in(2) ? center.y : center.z) += off;
    const auto place = static_cast<std::ptrdiff_t>(dice.below(spheres.size() + 1));
    spheres.insert(spheres.begin() + place, shape<Real>(center, 64));
  }
  return spheres;
}

/// Makes groups of 200 spheres, each group twenty times as far away as the previous one. Every cut
/// of a tree separates only one group.
template <typename Real>
Spheres<Real> ever_farther() {
  Spheres<Real> spheres;
  const int distances = sizeof(Real) == sizeof(float) ? 35 : 150;
  for (int i = 0; i < distances; ++i) {
    const double x = std::pow(20, i - distances * 0.6);
    for (int copy = 0; copy < 200; ++copy) spheres.push_back(shape<Real>({x, 0, 0}, x / 100));
  }
  return spheres;
}

/// Returns the same spheres in another precision.
template <typename To, typename From>
Spheres<To> as(const Spheres<From>& spheres) {
  Spheres<To> result;
  for (const SphereShape<From>& sphere : spheres) {
    result.push_back({vec_cast<To>(sphere.center), static_cast<To>(sphere.radius)});
  }
  return result;
}

}  // namespace parray::test
