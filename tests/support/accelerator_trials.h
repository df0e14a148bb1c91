#pragma once

#include <doctest/doctest.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>

#include "common/trace/reference/scalar_tracer.h"
#include "tests/support/ray_queries.h"
#include "tests/support/rooms.h"
#include "tests/support/trials.h"

/// Comparisons of accelerators with linear search, one ray at a time, bit by bit.
namespace parray::test {

/// Checks that accelerator A and linear search find the same hits for `rays` rays.
template <typename A, typename Real>
void check_equal(const std::string& name, const Spheres<Real>& spheres, Dice& dice, int rays) {
  CAPTURE(name);
  const Linear<Real> linear(spheres);
  const A accelerator(spheres);
  CHECK(accelerator.depth() <= A::max_depth);
  Questioner<Real> questioner(spheres, dice);
  std::array<int, query_kinds> hits{};
  std::array<int, query_kinds> different{};
  for (int i = 0; i < rays; ++i) {
    const int kind = i % query_kinds;
    const Query<Real> query = questioner.next(static_cast<QueryKind>(kind));
    Hit<Real> expected = query.best;
    Hit<Real> found = query.best;
    linear.enter(query.ray, query.sides, expected);
    accelerator.enter(query.ray, query.sides, found);
    const auto k = static_cast<std::size_t>(kind);
    hits[k] += expected.shape != query.best.shape ? 1 : 0;
    different[k] +=
        expected.t == found.t && expected.shape == found.shape && expected.leaving == found.leaving
            ? 0
            : 1;
  }
  for (std::size_t kind = 0; kind < query_kinds; ++kind) {
    CAPTURE(kind);
    CHECK(different[kind] == 0);
    if (kind < 4 && spheres.size() > 2) {
      CHECK(hits[kind] > 0);  // rays that hit nothing prove nothing
    }
  }
}

/// Calls check_equal() for all of the scenes above.
template <typename A, typename Real>
void check_equal_everywhere() {
  Dice dice(1);
  const int rays = static_cast<int>(trials(8000));
  check_equal<A>("scattered", scattered<Real>(dice), dice, 2 * rays);
  check_equal<A>("clustered", clustered<Real>(dice), dice, rays);
  check_equal<A>("one weekend", one_weekend<Real>(dice), dice, 2 * rays);
  check_equal<A>("tiny and far", tiny_far<Real>(dice), dice, 2 * rays);
  check_equal<A>("concentric", concentric<Real>(dice), dice, rays);
  check_equal<A>("collinear", collinear<Real>(dice), dice, rays);
  check_equal<A>("doubled grid", doubled_grid<Real>(dice), dice, 2 * rays);
  check_equal<A>("ring", ring<Real>(dice), dice, rays);
  check_equal<A>("every size", every_size<Real>(dice), dice, rays);
  check_equal<A>("10 000 coincident", coincident<Real>(10'000), dice, rays / 9);
  check_equal<A>("one", coincident<Real>(1), dice, rays);
  check_equal<A>("two", coincident<Real>(2), dice, rays);
  check_equal<A>("two apart", Spheres<Real>{shape<Real>({}, 1), shape<Real>({3, 0, 0}, 1)}, dice,
                 rays);
}

template <typename A, typename Real>
void check_nothing_is_never_hit() {
  const A accelerator(Spheres<Real>{});
  InsideStack<Real> sides;
  sides.start();
  Hit<Real> best;
  accelerator.enter(Ray<Real>({0, 0, 0}, {0, 0, 1}), sides, best);
  CHECK(best.shape == no_shape);
  CHECK(accelerator.depth() == 0);
  CHECK(accelerator.bytes() == 0);
}

/// Checks coincident spheres: a path that is inside the first few enters the next one.
template <typename A, typename Real>
void check_first_of_equals_wins() {
  const A accelerator(coincident<Real>(1000));
  const Ray<Real> ray({1, 2, -5}, {0, 0, 1});
  InsideStack<Real> sides;
  sides.start();
  for (std::uint32_t skipped = 0; skipped < 5; ++skipped) {
    Hit<Real> best;
    accelerator.enter(ray, sides, best);
    CHECK(best.shape == skipped);
    sides.cross(skipped, false);
  }
}

}  // namespace parray::test
