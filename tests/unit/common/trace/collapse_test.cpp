#include "common/trace/bvh/collapse.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <limits>
#include <vector>

#include "tests/support/dice.h"
#include "tests/support/rooms.h"

namespace parray::test {
namespace {

constexpr std::uint32_t leaf_size = 2;

std::vector<BuildSphere<float>> spheres_of(Dice& dice, std::uint32_t count) {
  std::vector<BuildSphere<float>> spheres;
  for (std::uint32_t i = 0; i < count; ++i) {
    const auto number = [&dice] { return static_cast<float>(dice.unit()); };
    spheres.push_back({number(), number(), number(), 0.1F * number(), i});
  }
  return spheres;
}

float half_area(const BinaryNode<float>& node) {
  const Vec3<float> d = node.box.hi - node.box.lo;
  return d.x * d.y + d.y * d.z + d.z * d.x;
}

using Tree = BinaryTree<float>;

/// Inner nodes of a tree, parents first.
std::vector<std::uint32_t> inner_nodes(const Tree& tree, std::uint32_t node = 0) {
  std::vector<std::uint32_t> found;
  if (tree.nodes[node].left != 0) {
    found.push_back(node);
    for (const std::uint32_t side : {tree.nodes[node].left, tree.nodes[node].right}) {
      const auto below = inner_nodes(tree, side);
      found.insert(found.end(), below.begin(), below.end());
    }
  }
  return found;
}

/// Sum of areas of the wide nodes made of `node` and what is below; counts leaves met.
template <int W>
float area_of(const Tree& tree, const Collapse<float, W>& collapse, std::uint32_t node,
              std::vector<int>& met) {
  const auto children = collapse.children(node);
  CHECK(children.count >= 2);
  CHECK(children.count <= W);
  float sum = half_area(tree.nodes[node]);
  for (int k = 0; k < children.count; ++k) {
    const std::uint32_t child = children.node[static_cast<std::size_t>(k)];
    if (tree.nodes[child].left != 0) {
      sum += area_of(tree, collapse, child, met);
      continue;
    }
    for (std::uint32_t i = tree.nodes[child].begin; i < tree.nodes[child].end; ++i) ++met.at(i);
  }
  return sum;
}

/// Children of `node` where the inner nodes whose bit is set in `kept` stay and others are opened.
int children_of(const Tree& tree, const std::vector<std::uint32_t>& inner, std::uint32_t kept,
                std::uint32_t node, bool first = true) {
  const auto bit =
      static_cast<std::size_t>(std::find(inner.begin(), inner.end(), node) - inner.begin());
  if (!first && (bit == inner.size() || (kept >> bit & 1) != 0)) return 1;
  return children_of(tree, inner, kept, tree.nodes[node].left, false) +
         children_of(tree, inner, kept, tree.nodes[node].right, false);
}

/// The least sum of areas by trying every set of nodes to keep.
template <int W>
float least_area(const Tree& tree) {
  const auto inner = inner_nodes(tree);
  float least = std::numeric_limits<float>::infinity();
  for (std::uint32_t kept = 1; kept < 1U << inner.size(); kept += 2) {  // always the root
    float sum = 0;
    bool possible = true;
    for (std::size_t bit = 0; bit < inner.size() && possible; ++bit) {
      if ((kept >> bit & 1) != 0) {
        sum += half_area(tree.nodes[inner[bit]]);
        possible = children_of(tree, inner, kept, inner[bit]) <= W;
      }
    }
    least = possible && sum < least ? sum : least;
  }
  return least;
}

template <int W>
void check_least(Tree& tree, std::uint32_t spheres) {
  std::vector<int> met(spheres);
  const Collapse<float, W> collapse(tree, 1);
  CHECK(area_of(tree, collapse, 0, met) == doctest::Approx(least_area<W>(tree)).epsilon(1e-5));
  CHECK(met == std::vector<int>(spheres, 1));
}

TEST_CASE("no other choice of wide nodes has a smaller area, and every sphere stays in one") {
  Dice dice(1);
  for (int round = 0; round < 60; ++round) {
    auto spheres = spheres_of(dice, 6 + static_cast<std::uint32_t>(round) % 14);
    Tree tree = build_binary_tree<float>(std::span(spheres), leaf_size, 1);
    if (inner_nodes(tree).size() <= 13) {
      const auto count = static_cast<std::uint32_t>(spheres.size());
      check_least<4>(tree, count);
      check_least<8>(tree, count);
    }
  }
}

TEST_CASE("areas that overflow or vanish still leave every sphere in one wide node") {
  for (const float scale : {1e30F, 0.0F}) {
    Dice dice(2);
    auto spheres = spheres_of(dice, 300);
    for (auto& sphere : spheres) {
      sphere = {sphere.x * scale, sphere.y * scale, sphere.z * scale, sphere.radius * scale,
                sphere.index};
    }
    const Tree tree = build_binary_tree<float>(std::span(spheres), leaf_size, 1);
    std::vector<int> met(spheres.size());
    const Collapse<float, 16> collapse(tree, 1);
    static_cast<void>(area_of(tree, collapse, 0, met));
    CHECK(met == std::vector<int>(spheres.size(), 1));
  }
}

}  // namespace
}  // namespace parray::test
