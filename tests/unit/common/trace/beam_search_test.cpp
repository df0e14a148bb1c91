#include <doctest/doctest.h>

#include <algorithm>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "common/trace/reference/scalar_tracer.h"
#include "tests/support/lane_search.h"
#include "tests/support/rooms.h"

/// Compares what beams find with a linear search for each single ray, bit by bit.
namespace parray::test {
namespace {

/// Returns a vector that differs from `v` by about `amount` in each component, relative to it.
template <typename Real>
Vec3<Real> varied(const Vec3<Real>& v, double amount, Dice& dice) {
  const auto near = [&](Real x) {
    return static_cast<Real>(static_cast<double>(x) * (1 + dice.between(-amount, amount)));
  };
  return {near(v.x), near(v.y), near(v.z)};
}

/// Rays like one another in groups of 64: thin groups and wide ones, with directions of the same
/// signs in most of them.
template <typename P>
std::vector<Query<typename P::Real>> groups_of_rays(const Stored<P>& stored, Dice& dice) {
  using Real = typename P::Real;
  const Spheres<Real> spheres = as<Real>(stored);
  Questioner<Real, typename P::Store> questioner(spheres, dice);
  std::vector<Query<Real>> queries;
  for (int group = 0; group < 150; ++group) {
    const auto kind = static_cast<QueryKind>(group % static_cast<int>(QueryKind::off_surface));
    const Ray<Real> first = questioner.next(kind).ray;
    const double spread = dice.one_in(4) ? 0 : dice.ten_to(-8, 0);
    const double shift = dice.one_in(2) ? 0 : dice.ten_to(-8, -1);
    for (int i = 0; i < 64; ++i) {
      Query<Real>& query = queries.emplace_back();
      Vec3<Real> direction = varied(first.direction, spread, dice);
      if (group % 10 == 9) direction = varied(first.direction, 3, dice);  // signs differ
      query.ray = {varied(first.origin, shift, dice), direction};
      query.sides.start();
    }
  }
  return queries;
}

/// Returns how many hits differ from `expected`. The queries travel in batches of many sizes.
template <typename Real>
int differences(LaneSearch<Real>& search, const std::vector<Query<Real>>& queries,
                const std::vector<Hit<Real>>& expected, std::uint32_t beam, Dice& dice) {
  int different = 0;
  for (std::size_t begin = 0; begin < queries.size();) {
    const std::size_t most = 64 * (1 + dice.below(16)) - begin % 3;
    const std::size_t count = std::min(queries.size() - begin, most);
    const auto found = search.find(std::span(queries).subspan(begin, count), beam);
    for (std::size_t i = 0; i < count; ++i) {
      const Hit<Real>& right = expected[begin + i];
      different += found[i].t == right.t && found[i].shape == right.shape ? 0 : 1;
    }
    begin += count;
  }
  return different;
}

template <typename P>
void check_beams(const std::string& name, const Stored<P>& stored, Dice& dice) {
  using Real = typename P::Real;
  CAPTURE(name);
  const auto queries = groups_of_rays<P>(stored, dice);
  const Linear<Real> linear(as<Real>(stored));
  std::vector<Hit<Real>> expected(queries.size());
  for (std::size_t i = 0; i < queries.size(); ++i) {
    linear.enter(queries[i].ray, queries[i].sides, expected[i]);
  }
  CHECK(std::ranges::count(expected, no_shape, &Hit<Real>::shape) <
        static_cast<std::ptrdiff_t>(queries.size()));
  for (const Isa isa : instruction_sets()) {
    CAPTURE(name_of(isa));
    for (const bool tree : {true, false}) {
      CAPTURE(tree);
      const auto search = lane_search<P>(isa, stored, tree, false);
      for (const std::uint32_t beam : {16U, 40U, 64U}) {
        CAPTURE(beam);
        CHECK(differences(*search, queries, expected, beam, dice) == 0);
      }
    }
  }
}

}  // namespace

TEST_CASE_TEMPLATE("beams find the very hits of linear search", P, SinglePrecision, MixedPrecision,
                   DoublePrecision) {
  using Store = typename P::Store;
  Dice dice(23);
  check_beams<P>("scattered", scattered<Store>(dice), dice);
  check_beams<P>("clustered", clustered<Store>(dice), dice);
  check_beams<P>("one weekend", one_weekend<Store>(dice), dice);
  check_beams<P>("tiny and far", tiny_far<Store>(dice), dice);
  check_beams<P>("concentric", concentric<Store>(dice), dice);
  check_beams<P>("doubled grid", doubled_grid<Store>(dice), dice);
  check_beams<P>("every size", every_size<Store>(dice), dice);
  check_beams<P>("many giants", touching_giants<Store>(dice, 40), dice);
  check_beams<P>("100 coincident", coincident<Store>(100), dice);
}

}  // namespace parray::test
