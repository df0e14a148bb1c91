// Rays that run along an axis, as all of an orthographic camera may: what they meet is what linear
// search finds, and boxes beside them are not entered.
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "common/math/lanes_scalar.h"
#include "common/trace/bvh/ray_groups.h"
#include "common/trace/reference/scalar_tracer.h"
#include "tests/support/lane_search.h"
#include "tests/support/rooms.h"

namespace parray::test {
namespace {

template <typename Store>
Spheres<Store> offset_cloud(Dice& dice, double scale, double offset) {
  Spheres<Store> spheres;
  for (int i = 0; i < 300; ++i) {
    const Vec3d center = Vec3d{offset, -offset, 0} + scale * dice.in_cube(10);
    spheres.push_back(shape<Store>(center, scale * dice.ten_to(0, 0.7)));
  }
  spheres.push_back(shape<Store>({0, scale * 1e4, 0}, scale * 1e4));  // touches 0
  return spheres;
}

/// A component of a direction that is as good as 0.
template <typename Store>
double next_to_zero(Dice& dice) {
  const std::array<double, 7> values{0,
                                     -0.0,
                                     1e-30,
                                     -1e-38,
                                     5e-324,
                                     -1e-310,
                                     1.1 / static_cast<double>(std::numeric_limits<Store>::max())};
  return values[dice.below(values.size())];
}

/// Touches a sphere's pole but for a few roundings, or begins where coordinates are 0.
template <typename P>
Ray<typename P::Real> along_axis(const Spheres<typename P::Store>& spheres, Dice& dice) {
  using Store = typename P::Store;
  const auto& sphere = spheres[dice.below(spheres.size())];
  const auto radius = static_cast<double>(sphere.radius);
  const Vec3d center = vec_cast<double>(sphere.center);
  const auto axis = dice.below(3);
  std::array<double, 3> o{center.x, center.y, center.z};
  std::array<double, 3> d{};
  for (double& component : d) component = next_to_zero<Store>(dice);
  d[axis] = dice.sign();
  const double roundoff = dice.one_in(2) ? RealTraits<Store>::unit_roundoff : 0x1p-53;
  const double size = length(center) + radius;
  o[(axis + 1) % 3] += dice.sign() * radius + dice.between(-40, 40) * roundoff * size;
  o[axis] -= d[axis] * radius * dice.ten_to(0, 4);
  for (double& coordinate : o) {
    if (dice.one_in(5)) coordinate = dice.one_in(2) ? 0 : -0.0;
  }
  return {vec_cast<typename P::Real>(Vec3d{o[0], o[1], o[2]}),
          vec_cast<typename P::Real>(Vec3d{d[0], d[1], d[2]})};
}

template <typename P>
void check_like_linear(Dice& dice, double scale, double offset) {
  using Real = typename P::Real;
  const auto stored = offset_cloud<typename P::Store>(dice, scale, offset);
  const Spheres<Real> spheres = as<Real>(stored);
  const Linear<Real> linear(spheres);
  std::vector<Query<Real>> queries(SampleBatch::most);
  std::vector<Hit<Real>> expected;
  for (Query<Real>& query : queries) {
    query.ray = along_axis<P>(stored, dice);
    query.sides.start();
    Hit<Real> hit;
    linear.enter(query.ray, query.sides, hit);
    expected.push_back(hit);
  }
  const auto met =
      std::ranges::count_if(expected, [](const auto& h) { return h.shape != no_shape; });
  CHECK(met > 50);
  for (const Isa isa : instruction_sets()) {
    CAPTURE(name_of(isa));
    const auto found = lane_search<P>(isa, stored, true, false)->find(queries);
    int different = 0;
    for (std::size_t i = 0; i < queries.size(); ++i) {
      different += found[i].t == expected[i].t && found[i].shape == expected[i].shape ? 0 : 1;
    }
    CHECK(different == 0);
  }
}

/// Whether a ray from `origin` that runs along planes at `low` and `high` may come between them.
template <typename Store>
bool comes_between(double origin, double low, double high, double reach, double direction) {
  using B = math::scalar::Reals<Store>;
  const B margin(Store(32) * RealTraits<Store>::unit_roundoff * static_cast<Store>(reach));
  const Slab<B> slab(B(static_cast<Store>(origin)), B(static_cast<Store>(direction)), margin,
                     Slab<B>::steepest(B(static_cast<Store>(reach))));
  const bool down = bits_of(slab.down) != 0;
  const auto at = [&](double plane, const B& shift) {
    return first_of(multiply_add(B(static_cast<Store>(plane)), slab.inverse, shift));
  };
  const Store enters = std::max(at(down ? high : low, slab.near), Store(0));
  return enters <= std::min(at(down ? low : high, slab.far), Store(1e16));
}

}  // namespace

TEST_CASE_TEMPLATE("rays along axes that graze spheres of any size meet what linear search finds",
                   P, SinglePrecision, MixedPrecision, DoublePrecision) {
  Dice dice(17);
  for (const double scale : {1e-15, 1e-12, 1e-9, 1e-6, 1e-3, 1.0, 1e3, 1e6, 1e9, 1e12}) {
    for (const double offset : {0.0, 30.0, 1e3}) {
      CAPTURE(scale);
      CAPTURE(offset);
      check_like_linear<P>(dice, scale, offset * scale);
    }
  }
}

TEST_CASE_TEMPLATE("a ray along the planes of boxes comes into those around it, and no others",
                   Store, float, double) {
  Dice dice(6);
  for (const double direction : {0.0, -0.0, 1e-50, -1e-45, 5e-324}) {
    for (int i = 0; i < 1000; ++i) {
      const double scale = dice.ten_to(-6, 15);
      const double low = scale * dice.between(-1, 1);
      const double high = low + scale * dice.ten_to(-4, 0);
      const double reach = scale * dice.ten_to(0.5, 1);
      const double within = low + (high - low) * dice.unit();
      const double off = reach * dice.ten_to(-4, 0);
      CHECK(comes_between<Store>(within, low, high, reach, direction));
      CHECK(comes_between<Store>(low, low, high, reach, direction));
      CHECK(comes_between<Store>(high, low, high, reach, direction));
      CHECK_FALSE(comes_between<Store>(low - off, low, high, reach, direction));
      CHECK_FALSE(comes_between<Store>(high + off, low, high, reach, direction));
    }
    // From where all coordinates are 0, of either sign.
    for (const double zero : {0.0, -0.0}) {
      CHECK(comes_between<Store>(zero, -1, 1, zero, direction));
      CHECK(comes_between<Store>(zero, -1e-15, 1e-15, zero, direction));
      CHECK_FALSE(comes_between<Store>(zero, 1e-15, 1, zero, direction));
      CHECK_FALSE(comes_between<Store>(zero, -1, -1e-15, zero, direction));
    }
  }
}

}  // namespace parray::test
