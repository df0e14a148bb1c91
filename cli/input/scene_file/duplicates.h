#pragma once

#include <cstddef>

#include "common/scene/scene.h"

namespace parray::input {

/// What remove_duplicates() left out. Places count from 0, in the order of the input.
struct Duplicates {
  std::size_t count = 0;
  std::size_t first = 0;     ///< place of the first that was left out
  std::size_t first_of = 0;  ///< place of the sphere that it repeats, which stays
};

/// Removes every sphere whose centre and radius are exactly those of an earlier one, whatever its
/// material, and the materials that only such spheres had: the scene becomes the very one that was
/// never given them. -0 is 0.
///
/// Rays find the earlier sphere, since ties go to the lower index; what a second surface in the
/// same place would add is not light but rounding, which decides anew at each crossing which of the
/// two comes first. That holds for glass as well: two spheres in one place count as one, refracting
/// once. A coat on a sphere needs a radius of its own.
///
/// About O(n); takes less than 32 bytes a sphere while it runs. The same for any number of threads.
Duplicates remove_duplicates(Scene& scene, int threads = 1);

}  // namespace parray::input
