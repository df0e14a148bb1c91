#include "common/trace/reference/octree.h"

#include <doctest/doctest.h>

#include <cstdint>
#include <vector>

#include "common/scene/limits.h"
#include "tests/support/accelerator_trials.h"
#include "tests/support/rooms.h"

namespace parray::test {
namespace {

/// Fewer than two cells a sphere, each with 14 planes and 12 bytes of links and padding at most.
template <typename Real>
std::size_t most_bytes(std::size_t spheres) {
  return spheres * (2 * (14 * sizeof(Real) + 16) + 4 * sizeof(Real) + sizeof(std::uint32_t));
}

}  // namespace

TEST_CASE_TEMPLATE("the octree finds the very hits of linear search", Real, float, double) {
  check_equal_everywhere<Octree<Real>, Real>();
}

TEST_CASE_TEMPLATE("an octree of nothing is never hit", Real, float, double) {
  check_nothing_is_never_hit<Octree<Real>, Real>();
}

TEST_CASE_TEMPLATE("in an octree, too, the first of equal spheres wins", Real, float, double) {
  check_first_of_equals_wins<Octree<Real>, Real>();
}

TEST_CASE_TEMPLATE("the octree's depth stays bounded where every halving peels off one place", Real,
                   float, double) {
  auto spheres = ever_farther<Real>();
  const Octree<Real> octree(spheres);
  CHECK(octree.depth() > 10);
  CHECK(octree.depth() <= Octree<Real>::max_depth);
  CHECK(octree.bytes() <= most_bytes<Real>(spheres.size()));
  std::erase_if(spheres, [](const SphereShape<Real>& sphere) {  // sizes that no scene may have
    return static_cast<double>(sphere.radius) < limits::min_radius ||
           static_cast<double>(sphere.center.x) > limits::max_length;
  });
  Dice dice(2);
  check_equal<Octree<Real>>("ever farther", spheres, dice, 1000);
}

TEST_CASE_TEMPLATE("octants are divided until each sphere has a leaf, and no further", Real, float,
                   double) {
  Spheres<Real> corners;  // two levels of eight, one sphere in each of the 64 smallest cubes
  for (int i = 0; i < 64; ++i) {
    corners.push_back(shape<Real>({static_cast<double>(i & 3), static_cast<double>((i >> 2) & 3),
                                   static_cast<double>(i >> 4)},
                                  0.1));
  }
  const Octree<Real> octree(corners);
  CHECK(octree.depth() == 3);
  const std::size_t cells = 1 + 8 + 64;
  const std::size_t shapes = 64 * (sizeof(SphereShape<Real>) + sizeof(std::uint32_t));
  CHECK((octree.bytes() - shapes) % cells == 0);
  CHECK((octree.bytes() - shapes) / cells >= 14 * sizeof(Real));

  const Octree<Real> one_place(coincident<Real>(10'000));
  CHECK(one_place.depth() == 1);

  // Close together far from the third: many halvings part nothing, and make no cells.
  const Octree<Real> three(Spheres<Real>{
      shape<Real>({0, 0, 0}, 1e-7), shape<Real>({1e-6, 0, 0}, 1e-7), shape<Real>({1, 1, 1}, 0.1)});
  CHECK(three.depth() == 3);
  CHECK(three.bytes() <= most_bytes<Real>(3));
}

TEST_CASE_TEMPLATE("a search that outgrows its room on the stack finds the same", Real, float,
                   double) {
  Dice dice(4);
  Spheres<Real> spheres;  // each reaches around all centres: every cell is met at distance 0
  for (int i = 0; i < 5000; ++i) {
    spheres.push_back(shape<Real>(dice.in_cube(1), dice.between(4, 5)));
  }
  check_equal<Octree<Real>>("overlapping", spheres, dice, 400);
}

TEST_CASE("building an octree twice gives the same") {
  Dice dice(3);
  const auto spheres = scattered<float>(dice);
  const Octree<float> first(spheres);
  const Octree<float> second(spheres);
  CHECK(first.depth() == second.depth());
  CHECK(first.bytes() == second.bytes());
}

}  // namespace parray::test
