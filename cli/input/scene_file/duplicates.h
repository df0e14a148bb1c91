#pragma once

#include <cstddef>

#include "common/scene/scene.h"

namespace parray::input {

/// Returns whether two spheres have the same centre and radius.
inline bool same_place(const Sphere& a, const Sphere& b) {
  return a.center == b.center && a.radius == b.radius;
}

/// Which spheres remove_duplicates() removed. Indices count from 0, in the order of the input.
struct Duplicates {
  std::size_t count = 0;
  std::size_t first = 0;     ///< index of the first removed sphere
  std::size_t first_of = 0;  ///< index of the sphere that `first` repeats
};

/// Removes each sphere whose centre and radius equal those of an earlier one; the material does not
/// matter. Removes the materials that only such spheres used. The scene becomes equal to one
/// without the duplicates. -0 equals 0.
///
/// Rays find the earlier sphere, because ties go to the lower index. A second surface in the same
/// place would add no light. Rounding would decide at each crossing which surface comes first. So
/// two glass spheres in one place refract once. A coat on a sphere needs its own radius.
///
/// Takes about linear time and less than 32 bytes per sphere. The result is the same for any number
/// of threads.
Duplicates remove_duplicates(Scene& scene, int threads = 1);

/// Keeps only the materials that shapes use, in the order of first use: by spheres, then by
/// capsules. The reader of scene files numbers them in this order, too.
void order_materials(Scene& scene);

}  // namespace parray::input
