// Screening a block's spheres in the stored type: none is lost that a ray of doubles enters, and
// few others pass.
#include "common/trace/bvh/screen.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <memory>

#include "common/math/lanes_scalar.h"
#include "common/trace/sphere.h"
#include "tests/support/dice.h"
#include "tests/support/rooms.h"

namespace parray::test {
namespace {

using B = math::scalar::FloatLanes;
using Block = SphereBlock<float, B::count>;

Block random_block(Dice& dice, double scale, double offset) {
  Block block;
  for (int lane = 0; lane < B::count; ++lane) {
    const Vec3d center = Vec3d{offset, 0, -offset} + dice.in_cube(scale);
    block.x[lane] = static_cast<float>(center.x);
    block.y[lane] = static_cast<float>(center.y);
    block.z[lane] = static_cast<float>(center.z);
    block.radius[lane] = static_cast<float>(scale * dice.ten_to(-3, 0));
  }
  return block;
}

double extent_of(const Block& block) {
  double extent = 0;
  for (int lane = 0; lane < B::count; ++lane) {
    for (const float at : {block.x[lane], block.y[lane], block.z[lane]}) {
      extent = std::max(extent, std::abs(double{at}) + double{block.radius[lane]});
    }
  }
  return extent;
}

/// Passes the first sphere at `off` radii from its centre.
Ray<double> passing(const Block& block, Dice& dice, double off, double length_of_direction = 1) {
  const Vec3d center{block.x[0], block.y[0], block.z[0]};
  const double radius = block.radius[0];
  const Vec3d along = dice.direction();
  const Vec3d aside = (off * radius) * dice.across(along);
  return {center + aside - (radius * dice.ten_to(0, 4)) * along, length_of_direction * along};
}

std::uint32_t screened(const Block& block, const Ray<double>& ray) {
  const auto columns = std::make_unique<ScreenColumns<float>>();
  const Vec3<float> origin = vec_cast<float>(ray.origin);
  const Vec3<float> direction = vec_cast<float>(ray.direction);
  const float reach = std::max({std::abs(origin.x), std::abs(origin.y), std::abs(origin.z)});
  const auto same = [](const Vec3<float>& v) { return Vec3<B>{B(v.x), B(v.y), B(v.z)}; };
  prepare_screen(*columns, 0, same(origin), same(direction), B(reach),
                 static_cast<float>(extent_of(block)));
  return may_enter<B>(*columns, 0, block);
}

std::uint32_t entered(const Block& block, const Ray<double>& ray) {
  std::uint32_t bits = 0;
  for (std::uint32_t lane = 0; lane < B::count; ++lane) {
    const ClosestApproach<double> passage(ray, shape_at<double>(&block, lane));
    bits |= static_cast<std::uint32_t>(passage.approaches()) << lane;
  }
  return bits;
}

}  // namespace

TEST_CASE(
    "no sphere that a ray enters is screened out, however it grazes, at any scale and offset") {
  Dice dice(23);
  int grazed = 0;
  for (int i = 0; i < 200000; ++i) {
    const double scale = dice.ten_to(-11, 13);
    const Block block = random_block(dice, scale, dice.one_in(3) ? 0 : scale * dice.ten_to(0, 6));
    const double near_one = 1 + dice.sign() * dice.ten_to(-16, -3);
    const double off = dice.one_in(4) ? dice.unit() : near_one;
    const Ray<double> ray = passing(block, dice, off, dice.ten_to(-3, 3));
    const std::uint32_t met = entered(block, ray);
    grazed += static_cast<int>(met & 1U);
    CHECK((met & ~screened(block, ray)) == 0);
  }
  CHECK(grazed > 50000);
}

TEST_CASE("a sphere passed at its own radius, or behind the ray, is screened out") {
  Dice dice(29);
  for (int i = 0; i < 20000; ++i) {
    const Block block = random_block(dice, dice.ten_to(-11, 13), 0);
    CHECK((screened(block, passing(block, dice, 1 + dice.ten_to(0, 2))) & 1U) == 0);
    const Ray<double> ray = passing(block, dice, dice.unit());
    const Ray<double> away(ray.origin, -ray.direction);
    CHECK((screened(block, away) & 1U) == 0);
  }
}

TEST_CASE("lanes without a sphere pass for no ray") {
  Dice dice(31);
  Block block = random_block(dice, 1, 0);
  block.x[1] = block.y[1] = block.z[1] = block.radius[1] = std::nanf("");
  for (int i = 0; i < 1000; ++i) {
    CHECK((screened(block, passing(block, dice, dice.unit())) & 2U) == 0);
  }
}

}  // namespace parray::test
