#include "common/trace/bvh.h"

#include <doctest/doctest.h>

#include "tests/support/accelerator_trials.h"

namespace parray::test {

TEST_CASE_TEMPLATE("the hierarchy finds the very hits of linear search", Real, float, double) {
  check_equal_everywhere<Bvh<Real>, Real>();
}

TEST_CASE_TEMPLATE("a hierarchy of nothing is never hit", Real, float, double) {
  check_nothing_is_never_hit<Bvh<Real>, Real>();
}

TEST_CASE_TEMPLATE("among equal spheres the first that is not ruled out wins", Real, float,
                   double) {
  check_first_of_equals_wins<Bvh<Real>, Real>();
}

TEST_CASE_TEMPLATE("depth stays bounded where every cut peels off one sphere", Real, float,
                   double) {
  const Bvh<Real> bvh(ever_farther<Real>());
  CHECK(bvh.depth() > 30);
  CHECK(bvh.depth() <= Bvh<Real>::max_depth);
}

TEST_CASE("building twice gives the same hierarchy") {
  Dice dice(3);
  const auto spheres = scattered<float>(dice);
  const Bvh<float> first(spheres);
  const Bvh<float> second(spheres);
  CHECK(first.depth() == second.depth());
  CHECK(first.bytes() == second.bytes());
}

}  // namespace parray::test
