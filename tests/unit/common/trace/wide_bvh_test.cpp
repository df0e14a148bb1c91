#include "common/trace/bvh/wide_bvh.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <string>
#include <vector>

#include "tests/support/rooms.h"
#include "tests/support/thorny_spheres.h"

namespace parray::test {
namespace {

/// The tables of one precision and width.
template <typename S, int Width>
struct Form {
  using Store = S;
  static constexpr int width = Width;
  using Tables = WideBvh<S, Width>;
};

template <typename Store>
struct NamedSpheres {
  std::string name;
  Spheres<Store> spheres;
};

template <typename Store>
Spheres<Store> wide_cloud(Dice& dice, int count) {
  Spheres<Store> spheres;
  for (int i = 0; i < count; ++i) {
    const double radius = dice.between(0.1, 0.5);  // first, whatever the compiler
    spheres.push_back(shape<Store>(dice.in_cube(100), radius));
  }
  return spheres;
}

/// One more than a block holds; without the two giants they fit into one.
template <typename Store>
Spheres<Store> fewer_than_a_block(Dice& dice, std::size_t width) {
  Spheres<Store> spheres = coincident<Store>(width - 1);
  for (int i = 0; i < 2; ++i) spheres.push_back(shape<Store>(dice.in_cube(10), 1e3));
  return spheres;
}

template <typename Store>
std::vector<NamedSpheres<Store>> collections() {
  Dice dice(1);
  return {{"none", {}},
          {"one", coincident<Store>(1)},
          {"17", coincident<Store>(17)},
          {"1000 coincident", coincident<Store>(1000)},
          {"scattered", scattered<Store>(dice)},
          {"clustered", clustered<Store>(dice)},
          {"one weekend", one_weekend<Store>(dice)},
          {"tiny and far", tiny_far<Store>(dice)},
          {"every size", every_size<Store>(dice)},
          {"three giants", touching_giants<Store>(dice, 3)},
          {"two giants and 3", fewer_than_a_block<Store>(dice, 4)},
          {"two giants and 7", fewer_than_a_block<Store>(dice, 8)},
          {"two giants and 15", fewer_than_a_block<Store>(dice, 16)},
          {"40 giants", touching_giants<Store>(dice, 40)},
          {"ever farther", ever_farther<Store>()}};
}

/// `check(spheres, tables)` with a tree and without.
template <typename F, typename Check>
void for_all_tables(Check check) {
  for (const auto& named : collections<typename F::Store>()) {
    CAPTURE(named.name);
    for (const bool tree : {false, true}) {
      CAPTURE(tree);
      check(named.spheres, typename F::Tables(named.spheres, tree, 1));
    }
  }
}

/// Walks a tree and counts what breaks its rules.
template <typename F>
class Walk {
 public:
  using Store = typename F::Store;
  using Tables = typename F::Tables;

  explicit Walk(const Tables& tables)
      : tables_(tables),
        block_met_(tables.slot_count() / F::width),
        node_met_(tables.node_count()) {
    if (tables.node_count() > 0) depth_ = visit(0, {});
  }

  [[nodiscard]] std::uint32_t depth() const { return depth_; }
  [[nodiscard]] int outside_boxes() const { return outside_; }
  [[nodiscard]] const std::vector<int>& block_met() const { return block_met_; }
  [[nodiscard]] const std::vector<int>& node_met() const { return node_met_; }

 private:
  using Box = std::array<Store, 6>;

  static Box box_of(const WideNode<Store, F::width>& node, int k) {
    Box box;
    for (std::size_t p = 0; p < 6; ++p) box[p] = node.planes[p % 3][p / 3][k];
    return box;
  }

  std::uint32_t visit(std::uint32_t index, std::vector<Box> around) {
    ++node_met_.at(index);
    const auto& node = tables_.nodes()[index];
    std::uint32_t below = 0;
    for (int k = 0; k < F::width; ++k) {
      const Box box = box_of(node, k);
      if (box[0] > box[3]) {  // absent
        continue;
      }
      around.push_back(box);
      if ((node.child[k] & ChildRef::is_block) != 0) {
        const std::uint32_t block = node.child[k] & ~ChildRef::is_block;
        ++block_met_.at(block);
        check_block(block, around);
      } else {
        below = std::max(below, visit(node.child[k], around));
      }
      around.pop_back();
    }
    return below + 1;
  }

  /// Every box around a block holds each of its spheres, with room for their rounding to spare.
  void check_block(std::uint32_t index, const std::vector<Box>& around) {
    const auto& block = tables_.blocks()[index];
    for (int lane = 0; lane < F::width; ++lane) {
      if (tables_.input_index(index * F::width + static_cast<std::uint32_t>(lane)) == no_shape) {
        continue;
      }
      const std::array<long double, 3> center{block.x[lane], block.y[lane], block.z[lane]};
      for (const Box& box : around) {
        for (std::size_t axis = 0; axis < 3; ++axis) {
          const long double radius = block.radius[lane];
          const long double spare =
              16.0L * RealTraits<Store>::unit_roundoff * (std::abs(center[axis]) + radius);
          outside_ += center[axis] - radius - spare < box[axis] ? 1 : 0;
          outside_ += center[axis] + radius + spare > box[axis + 3] ? 1 : 0;
        }
      }
    }
  }

  const Tables& tables_;
  std::vector<int> block_met_;
  std::vector<int> node_met_;
  int outside_ = 0;
  std::uint32_t depth_ = 0;
};

template <typename F>
bool same_tables(const typename F::Tables& a, const typename F::Tables& b) {
  using Store = typename F::Store;
  const auto same = [](const auto* x, const auto* y, std::size_t count) {
    return std::memcmp(x, y, count * sizeof *x) == 0;
  };
  if (a.slot_count() != b.slot_count() || a.node_count() != b.node_count() ||
      a.depth() != b.depth() || a.open_spheres() != b.open_spheres() ||
      !same(a.labels().at, b.labels().at, a.slot_count()) ||
      !same(a.blocks(), b.blocks(), a.slot_count() / F::width)) {
    return false;
  }
  for (std::uint32_t i = 0; i < a.node_count(); ++i) {  // one by one: padding follows each
    const WideNode<Store, F::width>& x = a.nodes()[i];
    const WideNode<Store, F::width>& y = b.nodes()[i];
    if (!same(&x.planes, &y.planes, 1) || !same(&x.child, &y.child, 1) ||
        !same(&x.order, &y.order, 1)) {
      return false;
    }
  }
  return true;
}

}  // namespace

#define PARRAY_FORMS \
  Form<float, 4>, Form<float, 8>, Form<float, 16>, Form<double, 4>, Form<double, 8>

TEST_CASE_TEMPLATE("every sphere has exactly one slot, and lanes without one hold no number", F,
                   PARRAY_FORMS) {
  for_all_tables<F>([](const auto& spheres, const auto& tables) {
    std::vector<int> met(spheres.size());
    int wrong = 0;
    for (std::uint32_t slot = 0; slot < tables.slot_count(); ++slot) {
      const auto& block = tables.blocks()[slot / F::width];
      const std::uint32_t lane = slot % F::width;
      const std::uint32_t index = tables.input_index(slot);
      if (index == no_shape) {
        wrong += std::isnan(block.x[lane]) && std::isnan(block.y[lane]) &&
                         std::isnan(block.z[lane]) && std::isnan(block.radius[lane])
                     ? 0
                     : 1;
        continue;
      }
      ++met.at(index);
      const auto& [center, radius] = spheres[index];
      wrong += block.x[lane] == center.x && block.y[lane] == center.y &&
                       block.z[lane] == center.z && block.radius[lane] == radius
                   ? 0
                   : 1;
    }
    CHECK(wrong == 0);
    CHECK(std::count(met.begin(), met.end(), 1) == static_cast<std::ptrdiff_t>(spheres.size()));
  });
}

TEST_CASE_TEMPLATE("open spheres come first and in input order; the tree holds all others", F,
                   PARRAY_FORMS) {
  for_all_tables<F>([](const auto& spheres, const auto& tables) {
    CHECK(tables.open_spheres() <= spheres.size());
    for (std::uint32_t slot = 1; slot < tables.open_spheres(); ++slot) {
      CHECK(tables.input_index(slot - 1) < tables.input_index(slot));
    }
    const Walk<F> walk(tables);
    // Without a tree all blocks are open, the one that is there without spheres too.
    const std::size_t open_blocks = tables.node_count() == 0
                                        ? walk.block_met().size()
                                        : (tables.open_spheres() + F::width - 1) / F::width;
    for (std::size_t block = 0; block < walk.block_met().size(); ++block) {
      CHECK_UNARY(walk.block_met()[block] == (block < open_blocks ? 0 : 1));
    }
    CHECK_UNARY(std::all_of(walk.node_met().begin(), walk.node_met().end(),
                            [](int met) { return met == 1; }));
    CHECK(tables.depth() == walk.depth());
  });
}

TEST_CASE_TEMPLATE("linear search has no tree; a tree leaves at most a block of giants open", F,
                   PARRAY_FORMS) {
  for_all_tables<F>([](const auto& spheres, const auto& tables) {
    if (tables.node_count() == 0) {
      CHECK(tables.open_spheres() == spheres.size());
    } else {
      CHECK(tables.open_spheres() <= F::width);
    }
  });
  using Store = typename F::Store;
  Dice dice(2);
  CHECK(typename F::Tables(one_weekend<Store>(dice), true, 1).open_spheres() == 1);
  CHECK(typename F::Tables(touching_giants<Store>(dice, 3), true, 1).open_spheres() == 3);
  CHECK(typename F::Tables(touching_giants<Store>(dice, 17), true, 1).open_spheres() == 0);
  CHECK(typename F::Tables(scattered<Store>(dice), true, 1).node_count() > 1);
  CHECK(typename F::Tables(scattered<Store>(dice), false, 1).node_count() == 0);
}

TEST_CASE_TEMPLATE("boxes hold their spheres with room for rounding", F, PARRAY_FORMS) {
  for_all_tables<F>(
      [](const auto&, const auto& tables) { CHECK(Walk<F>(tables).outside_boxes() == 0); });
}

TEST_CASE_TEMPLATE("every octant's order names each child once, farther ones first", F,
                   PARRAY_FORMS) {
  for_all_tables<F>([](const auto&, const auto& tables) {
    int wrong = 0;
    for (std::uint32_t n = 0; n < tables.node_count(); ++n) {
      const auto& node = tables.nodes()[n];
      for (int octant = 0; octant < 8; ++octant) {
        std::array<int, F::width> met{};
        double before = std::numeric_limits<double>::infinity();
        for (const std::uint8_t k : node.order[octant]) {
          ++met.at(k);
          if (node.planes[0][0][k] > node.planes[0][1][k]) continue;
          double along = 0;  // of the middle, in the direction that the octant's rays take
          double size = 0;
          for (int axis = 0; axis < 3; ++axis) {
            const double lo = node.planes[axis][0][k];
            const double hi = node.planes[axis][1][k];
            along += (octant >> axis & 1) != 0 ? -(lo + hi) : lo + hi;
            size += std::abs(lo) + std::abs(hi);
          }
          wrong +=
              along <= before + 8 * RealTraits<typename F::Store>::unit_roundoff * size ? 0 : 1;
          before = along;
        }
        wrong += std::count(met.begin(), met.end(), 1) == F::width ? 0 : 1;
      }
    }
    CHECK(wrong == 0);
  });
}

TEST_CASE_TEMPLATE("many spheres make the same tables with any number of threads", F,
                   PARRAY_FORMS) {
  using Store = typename F::Store;
  Dice dice(3);
  // Enough for seven threads to share the first cuts; a giant in their midst is moved away.
  Spheres<Store> scattered = wide_cloud<Store>(dice, 250'000);
  scattered[100'000].radius = 1000;
  for (const Spheres<Store>& spheres : {scattered, coincident<Store>(100'000)}) {
    const typename F::Tables one(spheres, true, 1);
    CHECK(one.depth() < 20);
    CHECK(one.open_spheres() == (spheres.size() == scattered.size() ? 1 : 0));
    CHECK_UNARY(same_tables<F>(one, typename F::Tables(spheres, true, 7)));
  }
}

TEST_CASE_TEMPLATE("large trees have full blocks, whether spheres are scattered or coincide", F,
                   PARRAY_FORMS) {
  using Store = typename F::Store;
  Dice dice(5);
  for (const Spheres<Store>& spheres :
       {wide_cloud<Store>(dice, 20'000), coincident<Store>(20'000)}) {
    const typename F::Tables tables(spheres, true, 1);
    const auto count = static_cast<double>(spheres.size());
    CHECK(tables.slot_count() < 1.02 * count);
    if (sizeof(Store) == sizeof(float)) {  // nodes of 4 are padded by a third
      CHECK(static_cast<double>(tables.bytes()) < (F::width == 4   ? 41
                                                   : F::width == 8 ? 30
                                                                   : 24) *
                                                      count);
    }
  }
}

TEST_CASE("tables of other spheres are not the same") {
  using F = Form<float, 8>;
  Dice dice(4);
  Spheres<float> spheres = scattered<float>(dice);
  const F::Tables before(spheres, true, 1);
  spheres.back().radius *= 1.0001F;
  CHECK_FALSE(same_tables<F>(before, F::Tables(spheres, true, 1)));
}

#undef PARRAY_FORMS

}  // namespace parray::test
