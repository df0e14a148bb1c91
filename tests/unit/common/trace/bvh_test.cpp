#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "common/scene/limits.h"
#include "common/trace/reference/scalar_tracer.h"
#include "tests/support/lane_search.h"
#include "tests/support/rooms.h"
#include "tests/support/trials.h"

/// What lanes of every instruction set find, with the tree and without, against linear search by
/// the scalar functions, bit by bit.
namespace parray::test {
namespace {

template <typename Real>
struct Trial {
  std::vector<Query<Real>> queries;
  std::vector<QueryKind> kinds;
  std::vector<Hit<Real>> expected;

  void add(QueryKind kind, Query<Real> query, const Linear<Real>& linear) {
    Hit<Real> hit = query.best;
    linear.enter(query.ray, query.sides, hit);
    queries.push_back(std::move(query));
    kinds.push_back(kind);
    expected.push_back(hit);
  }

  /// The queries whose paths are inside of nothing.
  [[nodiscard]] Trial outside() const {
    Trial result;
    for (std::size_t i = 0; i < queries.size(); ++i) {
      if (queries[i].sides.inside().empty()) {
        result.queries.push_back(queries[i]);
        result.kinds.push_back(kinds[i]);
        result.expected.push_back(expected[i]);
      }
    }
    return result;
  }
};

template <typename P>
Trial<typename P::Real> trial(const Stored<P>& stored, Dice& dice, int rays) {
  using Real = typename P::Real;
  const Spheres<Real> spheres = as<Real>(stored);
  const Linear<Real> linear(spheres);
  Questioner<Real, typename P::Store> questioner(spheres, dice);
  Trial<Real> result;
  for (int i = 0; i < rays; ++i) {
    const auto kind = static_cast<QueryKind>(i % query_kinds);
    result.add(kind, questioner.next(kind), linear);
  }
  return result;
}

template <typename Real>
bool equal(const Hit<Real>& a, const Hit<Real>& b) {
  return a.t == b.t && a.shape == b.shape && a.leaving == b.leaving;
}

/// Paths travel in batches of many sizes, so that every lane and every group gets its share.
template <typename Real>
void check_finds(LaneSearch<Real>& search, const Trial<Real>& trial) {
  Dice dice(11);
  std::array<int, query_kinds> different{};
  const std::span<const Query<Real>> all(trial.queries);
  for (std::size_t begin = 0; begin < all.size();) {
    const std::size_t most = dice.one_in(3) ? SampleBatch::most : 1 + dice.below(SampleBatch::most);
    const std::size_t count = std::min(most, all.size() - begin);
    const std::vector<Hit<Real>> found = search.find(all.subspan(begin, count));
    for (std::size_t i = 0; i < count; ++i) {
      different[static_cast<std::size_t>(trial.kinds[begin + i])] +=
          equal(found[i], trial.expected[begin + i]) ? 0 : 1;
    }
    begin += count;
  }
  for (int kind = 0; kind < query_kinds; ++kind) {
    CAPTURE(kind);
    CHECK(different[static_cast<std::size_t>(kind)] == 0);
  }
}

/// Rays that meet nothing prove nothing.
template <typename Real>
void check_hits(const Trial<Real>& trial) {
  std::array<int, query_kinds> entered{};
  std::array<int, query_kinds> left{};
  for (std::size_t i = 0; i < trial.queries.size(); ++i) {
    const auto kind = static_cast<std::size_t>(trial.kinds[i]);
    entered[kind] += trial.expected[i].shape != no_shape && !trial.expected[i].leaving ? 1 : 0;
    left[kind] += trial.expected[i].leaving ? 1 : 0;
  }
  for (const QueryKind kind : {QueryKind::from_afar, QueryKind::from_amid, QueryKind::along_axes,
                               QueryKind::on_planes, QueryKind::along_diagonals}) {
    CHECK(entered[static_cast<std::size_t>(kind)] > 0);
  }
  CHECK(left[static_cast<std::size_t>(QueryKind::from_inside)] > 0);
}

template <typename P>
void check_lanes(const std::string& name, const Stored<P>& spheres, Dice& dice, int rays) {
  CAPTURE(name);
  const auto all = trial<P>(spheres, dice, rays);
  const auto outside = all.outside();
  if (spheres.size() > 2) check_hits(all);
  for (const Isa isa : instruction_sets()) {
    CAPTURE(name_of(isa));
    for (const bool tree : {true, false}) {
      CAPTURE(tree);
      check_finds(*lane_search<P>(isa, spheres, tree, true), all);
      check_finds(*lane_search<P>(isa, spheres, tree, false), outside);
    }
  }
}

}  // namespace

TEST_CASE_TEMPLATE("lanes find the very hits of linear search", P, SinglePrecision, MixedPrecision,
                   DoublePrecision) {
  using Store = typename P::Store;
  Dice dice(1);
  const int rays = static_cast<int>(trials(7000));
  check_lanes<P>("scattered", scattered<Store>(dice), dice, 2 * rays);
  check_lanes<P>("clustered", clustered<Store>(dice), dice, rays);
  check_lanes<P>("one weekend", one_weekend<Store>(dice), dice, 2 * rays);
  check_lanes<P>("tiny and far", tiny_far<Store>(dice), dice, 2 * rays);
  check_lanes<P>("concentric", concentric<Store>(dice), dice, rays);
  check_lanes<P>("collinear", collinear<Store>(dice), dice, rays);
  check_lanes<P>("doubled grid", doubled_grid<Store>(dice), dice, 2 * rays);
  check_lanes<P>("ring", ring<Store>(dice), dice, rays);
  check_lanes<P>("every size", every_size<Store>(dice), dice, rays);
  check_lanes<P>("few giants", touching_giants<Store>(dice, 3), dice, 2 * rays);
  check_lanes<P>("many giants", touching_giants<Store>(dice, 40), dice, rays);
  check_lanes<P>("10 000 coincident", coincident<Store>(10'000), dice, rays / 10);
  check_lanes<P>("one", coincident<Store>(1), dice, rays);
  check_lanes<P>("two", coincident<Store>(2), dice, rays);
  check_lanes<P>("two apart", {shape<Store>({}, 1), shape<Store>({3, 0, 0}, 1)}, dice, rays);
}

TEST_CASE_TEMPLATE("where there is no sphere, none is hit", P, SinglePrecision, MixedPrecision,
                   DoublePrecision) {
  for (const Isa isa : instruction_sets()) {
    for (const bool tree : {true, false}) {
      for (const bool sides : {true, false}) {
        const auto search = lane_search<P>(isa, {}, tree, sides);
        CHECK(search->depth() == 0);
        Query<typename P::Real> query;
        query.sides.start();
        const auto found = search->find(std::vector(500, query));
        for (const auto& hit : found) CHECK_UNARY(hit.shape == no_shape);
      }
    }
  }
}

TEST_CASE_TEMPLATE("among equal spheres the first that is not ruled out wins", P, SinglePrecision,
                   MixedPrecision, DoublePrecision) {
  using Real = typename P::Real;
  const auto spheres = coincident<typename P::Store>(1000);
  for (const Isa isa : instruction_sets()) {
    CAPTURE(name_of(isa));
    for (const bool tree : {true, false}) {
      CAPTURE(tree);
      const auto search = lane_search<P>(isa, spheres, tree, true);
      std::vector<Query<Real>> queries(40);  // query i is inside of the first i
      std::vector<std::uint32_t> inside;
      for (std::uint32_t i = 0; i < queries.size(); ++i) {
        queries[i].ray = Ray<Real>({1, 2, -5}, {0, 0, 1});
        for (const std::uint32_t shape : inside) queries[i].sides.cross(shape, false);
        inside.push_back(i);
      }
      const auto found = search->find(queries);
      for (std::uint32_t i = 0; i < queries.size(); ++i) {
        CHECK(found[i].shape == i);
        CHECK_FALSE(found[i].leaving);
      }
    }
  }
}

/// Returns the number of nodes from a node to the deepest leaf below it, both included.
template <typename Store>
std::uint32_t depth_of(const BinaryTree<Store>& tree, std::uint32_t node = 0) {
  const auto& [box, begin, end, left, right] = tree.nodes[node];
  return left == 0 ? 1 : 1 + std::max(depth_of(tree, left), depth_of(tree, right));
}

TEST_CASE_TEMPLATE("depth stays bounded where every cut peels off one place", Store, float,
                   double) {
  const Spheres<Store> spheres = ever_farther<Store>();
  std::vector<BuildSphere<Store>> built;
  for (const auto& [center, radius] : spheres) {
    built.push_back(
        {center.x, center.y, center.z, radius, static_cast<std::uint32_t>(built.size())});
  }
  const BinaryTree<Store> tree = build_binary_tree<Store>(std::span(built), 4, 1);
  CHECK(depth_of(tree) > 30);
  CHECK(depth_of(tree) <= max_tree_depth);
  const WideBvh<Store, 4> tables(spheres, true, 1);
  CHECK(tables.depth() > 10);
  CHECK(tables.depth() <= max_tree_depth);
  CHECK(tables.stack_size() <= Workspace<Store, Store>::stack_entries);
}

TEST_CASE_TEMPLATE("a tree so deep that few rays travel together finds the same", P,
                   SinglePrecision, MixedPrecision, DoublePrecision) {
  auto spheres = ever_farther<typename P::Store>();
  std::erase_if(spheres, [](const auto& sphere) {  // sizes that no scene may have
    return static_cast<double>(sphere.radius) < limits::min_radius ||
           static_cast<double>(sphere.center.x) > limits::max_length;
  });
  Dice dice(3);
  check_lanes<P>("ever farther", spheres, dice, 2200);
}

}  // namespace parray::test
