#pragma once

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include "common/trace/linear.h"
#include "tests/support/dice.h"

/// Spheres and rays on which accelerators are held against linear search, bit by bit.
namespace parray::test {

template <typename Real>
using Spheres = std::vector<SphereShape<Real>>;

template <typename Real>
SphereShape<Real> shape(const Vec3d& center, double radius) {
  return {vec_cast<Real>(center), static_cast<Real>(radius)};
}

// --- scenes

template <typename Real>
Spheres<Real> scattered(Dice& dice) {
  Spheres<Real> spheres;
  for (int i = 0; i < 300; ++i) {
    spheres.push_back(shape<Real>(dice.in_cube(10), dice.between(0.05, 1)));
  }
  return spheres;
}

template <typename Real>
Spheres<Real> clustered(Dice& dice) {
  Spheres<Real> spheres;
  for (int cluster = 0; cluster < 20; ++cluster) {
    const Vec3d center = dice.in_cube(1000);
    for (int i = 0; i < 15; ++i) {
      spheres.push_back(shape<Real>(center + dice.in_cube(0.3), dice.ten_to(-3, -1)));
    }
  }
  return spheres;
}

/// A ground of radius 1000 and small spheres that stand on it.
template <typename Real>
Spheres<Real> one_weekend(Dice& dice) {
  Spheres<Real> spheres{shape<Real>({0, -1000, 0}, 1000)};
  for (int x = -9; x < 9; ++x) {
    for (int z = -9; z < 9; ++z) {
      spheres.push_back(shape<Real>({x + 0.9 * dice.unit(), 0.2, z + 0.9 * dice.unit()}, 0.2));
    }
  }
  return spheres;
}

/// Radii down to 1/64 of the spacing of single-precision numbers at their centres.
template <typename Real>
Spheres<Real> tiny_far(Dice& dice) {
  Spheres<Real> spheres;
  for (int i = 0; i < 300; ++i) {
    const Vec3d center{1e6 + dice.between(-20, 20), -1e6 + dice.between(-20, 20),
                       dice.between(-2, 2)};
    spheres.push_back(shape<Real>(center, dice.ten_to(-3, 0)));
  }
  return spheres;
}

template <typename Real>
Spheres<Real> concentric(Dice& dice) {
  Spheres<Real> spheres;
  for (int i = 0; i < 300; ++i) {
    spheres.push_back(shape<Real>({1, 2, 3}, dice.ten_to(-3, 3)));
  }
  return spheres;
}

template <typename Real>
Spheres<Real> collinear(Dice& dice) {
  Spheres<Real> spheres;
  for (int i = 0; i < 150; ++i) {
    spheres.push_back(shape<Real>({static_cast<double>(i), 0, 0}, 0.5));
    const double x = dice.between(-100, 100);
    spheres.push_back(shape<Real>({x, x, x}, 0.25));
  }
  return spheres;
}

/// Touching spheres on whole numbers, each there twice: ties wherever a ray runs along the grid.
template <typename Real>
Spheres<Real> doubled_grid(Dice& dice) {
  Spheres<Real> spheres;
  for (int copy = 0; copy < 2; ++copy) {
    for (int x = 0; x < 12; ++x) {
      for (int y = 0; y < 12; ++y) {
        spheres.push_back(shape<Real>(
            {static_cast<double>(x), static_cast<double>(y), static_cast<double>(dice.below(2))},
            0.5));
      }
    }
  }
  return spheres;
}

/// Far from the origin of the coordinates but level with it, so that a ray may start near 0.
template <typename Real>
Spheres<Real> ring(Dice& dice) {
  Spheres<Real> spheres;
  for (int i = 0; i < 200; ++i) {
    const double x = dice.between(-1, 1);
    const Vec3d around{x, 0, dice.sign() * std::sqrt(1 - x * x)};
    spheres.push_back(shape<Real>(1000 * around + dice.in_cube(0.1), dice.between(0.01, 2)));
  }
  return spheres;
}

template <typename Real>
Spheres<Real> every_size(Dice& dice) {
  Spheres<Real> spheres;
  for (int i = 0; i < 200; ++i) {
    const double size = dice.ten_to(-6, 6);
    spheres.push_back(shape<Real>((dice.ten_to(0, 2) * size) * dice.direction(), size));
  }
  return spheres;
}

template <typename Real>
Spheres<Real> coincident(std::size_t count) {
  return Spheres<Real>(count, shape<Real>({1, 2, 3}, 0.7));
}

// --- rays

template <typename Real>
struct Query {
  Ray<Real> ray{{0, 0, 0}, {1, 0, 0}};
  Sides<Real> sides;
  Hit<Real> best;
};

template <typename Real>
class Questioner {
 public:
  Questioner(const Spheres<Real>& spheres, Dice& dice)
      : spheres_(spheres), dice_(dice), lo_(spheres[0].center), hi_(lo_) {
    for (const auto& [c, radius] : spheres) {
      lo_ = {min_of(lo_.x, c.x), min_of(lo_.y, c.y), min_of(lo_.z, c.z)};
      hi_ = {max_of(hi_.x, c.x), max_of(hi_.y, c.y), max_of(hi_.z, c.z)};
    }
  }

  Query<Real> next(int kind) {
    Query<Real> query;
    query.sides.start({});
    switch (kind) {
      case 0: {  // from afar
        const Vec3d target = vec_cast<double>(any().center);
        const Vec3d from = target + dice_.ten_to(0, 4) * dice_.direction();
        query.ray = aimed(from, target + static_cast<double>(any().radius) * dice_.direction());
        break;
      }
      case 1:  // from amid them
        query.ray = aimed(vec_cast<double>(any().center) + dice_.direction(),
                          vec_cast<double>(any().center));
        break;
      case 2:  // along an axis or a plane, with zeros of either sign and denormals
        query.ray = {on_planes(), axis_direction()};
        break;
      case 3:  // from the planes of boxes
        query.ray = {on_planes(), vec_cast<Real>(dice_.direction())};
        break;
      case 4:
        query.ray = grazing();
        break;
      case 5:
        query.ray = grazing_pole();
        break;
      case 6:  // along a diagonal or across it, from the planes that bound a sphere there
        query.ray = {on_diagonal_planes(), diagonal_direction()};
        break;
      case 7:  // from where cubes are halved
        query.ray = {on_borders(),
                     dice_.one_in(2) ? axis_direction() : vec_cast<Real>(dice_.direction())};
        break;
      case 8: {  // off a surface, not back into it
        const std::uint32_t index = any_index();
        const Vec3<Real> n = normalize(vec_cast<Real>(dice_.direction()));
        query.ray = {spheres_[index].center + spheres_[index].radius * n,
                     n + vec_cast<Real>(0.99 * dice_.direction())};
        query.sides.stand_on(index, n);
        break;
      }
      default: {  // from inside some, which they leave somewhere
        const std::uint32_t index = any_index();
        const auto& sphere = spheres_[index];
        query.ray = {
            sphere.center + (sphere.radius * Real(0.7)) * vec_cast<Real>(dice_.direction()),
            vec_cast<Real>(dice_.direction())};
        query.sides.cross(index, false);
        query.best = {exit_distance(query.ray, sphere), index, true};
        break;
      }
    }
    if (kind < 8 && dice_.one_in(4)) {
      query.sides.stand_on(any_index(), {0, 0, 1});
    }
    return query;
  }

 private:
  std::uint32_t any_index() { return dice_.below32(static_cast<std::uint32_t>(spheres_.size())); }
  const SphereShape<Real>& any() { return spheres_[any_index()]; }

  static Ray<Real> aimed(const Vec3d& from, const Vec3d& to) {
    const Vec3<Real> origin = vec_cast<Real>(from);
    const Vec3d way = to - vec_cast<double>(origin);
    const double distance = length(way);
    return {origin, vec_cast<Real>(distance > 0 ? (1 / distance) * way : Vec3d{0, 0, 1})};
  }

  /// A coordinate of a sphere, of its bounds, or of the bounds with a margin for rounding.
  Real plane(Real center, Real radius, Real size) {
    const Real margin = Real(32) * RealTraits<Real>::unit_roundoff * size;
    const std::array<Real, 5> choices{0, radius, -radius, radius + margin, -(radius + margin)};
    return center + choices[dice_.below(choices.size())];
  }

  Vec3<Real> on_planes() {
    const auto& s = any();
    const Real size = std::max({std::abs(s.center.x), std::abs(s.center.y), std::abs(s.center.z)});
    Vec3<Real> p{plane(s.center.x, s.radius, size + s.radius),
                 plane(s.center.y, s.radius, size + s.radius),
                 plane(s.center.z, s.radius, size + s.radius)};
    if (dice_.one_in(2)) {
      p.x = p.x - 20 * s.radius;
    }
    return p;
  }

  Real near_zero() {
    const std::array<Real, 6> values{Real(0),
                                     -Real(0),
                                     std::numeric_limits<Real>::denorm_min(),
                                     -std::numeric_limits<Real>::denorm_min(),
                                     Real(1e-30),
                                     Real(-1e-30)};
    return values[dice_.below(values.size())];
  }

  Vec3<Real> axis_direction() {
    const auto along = static_cast<Real>(dice_.sign());
    const auto other = dice_.one_in(3) ? static_cast<Real>(dice_.sign()) : near_zero();
    switch (dice_.below(3)) {
      case 0:
        return {along, other, near_zero()};
      case 1:
        return {near_zero(), along, other};
      default:
        return {other, near_zero(), along};
    }
  }

  /// (+-1, +-1, +-1)
  Vec3d diagonal() {
    const double x = dice_.sign();
    const double y = dice_.sign();
    return {x, y, dice_.sign()};
  }

  /// Where a diagonal leaves a sphere's bounds, with a margin for rounding or without, and moved
  /// within that plane by whole radii.
  Vec3<Real> on_diagonal_planes() {
    const auto& s = any();
    const Vec3<Real> n = vec_cast<Real>(diagonal());
    const Real size =
        std::max({std::abs(s.center.x), std::abs(s.center.y), std::abs(s.center.z)}) + s.radius;
    const Real out = plane(Real(0), s.radius / square_root(Real(3)), size);
    const auto step = static_cast<Real>(dice_.below(20)) * s.radius;
    return s.center + out * n + step * Vec3<Real>{n.x, -n.y, Real(0)};
  }

  /// A diagonal, or a direction at right angles to one but for a few roundings.
  Vec3<Real> diagonal_direction() {
    const Vec3d n = diagonal();
    if (dice_.one_in(3)) {
      return vec_cast<Real>(n) + Vec3<Real>{near_zero(), near_zero(), near_zero()};
    }
    Vec3<Real> across = dice_.one_in(2) ? vec_cast<Real>(Vec3d{n.x, -n.y, 0})
                                        : vec_cast<Real>(dice_.across(normalize(n)));
    across.z = across.z + near_zero();
    return across;
  }

  /// A corner of the cubes that halving the one around all centres gives, or of the octants of a
  /// coarser level.
  Vec3<Real> on_borders() {
    const Real side = std::max({hi_.x - lo_.x, hi_.y - lo_.y, hi_.z - lo_.z});
    const auto level = dice_.below(12);
    const auto parts = static_cast<double>(1U << level);
    const auto step = [&] {
      const double part = static_cast<double>(dice_.below(1U << level)) + 0.5;
      return static_cast<Real>(part / parts - 0.5) * side;
    };
    const Real x = step();
    const Real y = step();
    return Real(0.5) * (lo_ + hi_) + Vec3<Real>{x, y, step()};
  }

  /// Within a few roundings of touching a sphere.
  Ray<Real> grazing() {
    const auto& sphere = any();
    const double radius = static_cast<double>(sphere.radius);
    const double distance = radius * dice_.ten_to(0.01, 4);
    const Vec3d center = vec_cast<double>(sphere.center);
    const Vec3<Real> origin = vec_cast<Real>(center + distance * dice_.direction());
    const Vec3d to_center = center - vec_cast<double>(origin);
    const double scale = std::max(1.0, length(to_center) / radius);
    const double steps =
        dice_.between(-8, 8) * 2 * static_cast<double>(RealTraits<Real>::unit_roundoff);
    const double sine = std::min((1 + steps * scale) * radius / length(to_center), 1.0);
    const Vec3d axis = normalize(to_center);
    return {origin, vec_cast<Real>(std::sqrt(1 - sine * sine) * axis + sine * dice_.across(axis))};
  }

  /// The same where a sphere touches its bounds, which then decide between hit and miss.
  Ray<Real> grazing_pole() {
    const auto& sphere = any();
    const double radius = static_cast<double>(sphere.radius);
    const auto axis = dice_.below(4);  // 3: a diagonal
    const double side = dice_.sign();
    const Vec3d pole =
        axis == 3 ? normalize(diagonal())
                  : Vec3d{axis == 0 ? side : 0, axis == 1 ? side : 0, axis == 2 ? side : 0};
    const Vec3d touched = vec_cast<double>(sphere.center) + radius * pole;
    // From afar, or from the point nearest to the origin of the coordinates, whose own rounding is
    // small.
    const bool from_zero = dice_.one_in(2);
    const Vec3d across = cross(pole, cross(touched, pole));
    const Vec3d level = from_zero && length(across) > 0 ? normalize(across) : dice_.across(pole);
    const Vec3d way = normalize(level + (dice_.sign() * dice_.ten_to(-12, -3)) * pole);
    const double back = from_zero ? dot(touched, way) : radius * dice_.ten_to(0, 5);
    const double unit = 2 * static_cast<double>(RealTraits<Real>::unit_roundoff);
    const double off = dice_.between(-2, 2) * unit * std::max(radius, std::abs(back));
    return {vec_cast<Real>(touched + off * pole - back * way), vec_cast<Real>(way)};
  }

  const Spheres<Real>& spheres_;
  Dice& dice_;
  Vec3<Real> lo_;  ///< bounds of the centres
  Vec3<Real> hi_;
};

constexpr int query_kinds = 10;

/// Asks the accelerator A and linear search about `rays` rays.
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
    const Query<Real> query = questioner.next(kind);
    Hit<Real> expected = query.best;
    Hit<Real> found = query.best;
    linear.enter(query.ray, query.sides, expected);
    accelerator.enter(query.ray, query.sides, found);
    const auto k = static_cast<std::size_t>(kind);
    hits[k] += expected.sphere != query.best.sphere ? 1 : 0;
    different[k] += expected.t == found.t && expected.sphere == found.sphere &&
                            expected.leaving == found.leaving
                        ? 0
                        : 1;
  }
  for (std::size_t kind = 0; kind < query_kinds; ++kind) {
    CAPTURE(kind);
    CHECK(different[kind] == 0);
    if (kind < 4 && spheres.size() > 2) {
      CHECK(hits[kind] > 0);  // rays that meet nothing prove nothing
    }
  }
}

/// check_equal() for all of the scenes above.
template <typename A, typename Real>
void check_equal_everywhere() {
  Dice dice(1);
  constexpr int rays = 20'000;
  check_equal<A>("scattered", scattered<Real>(dice), dice, 2 * rays);
  check_equal<A>("clustered", clustered<Real>(dice), dice, rays);
  check_equal<A>("one weekend", one_weekend<Real>(dice), dice, 2 * rays);
  check_equal<A>("tiny and far", tiny_far<Real>(dice), dice, 2 * rays);
  check_equal<A>("concentric", concentric<Real>(dice), dice, rays);
  check_equal<A>("collinear", collinear<Real>(dice), dice, rays);
  check_equal<A>("doubled grid", doubled_grid<Real>(dice), dice, 2 * rays);
  check_equal<A>("ring", ring<Real>(dice), dice, rays);
  check_equal<A>("every size", every_size<Real>(dice), dice, rays);
  check_equal<A>("10 000 coincident", coincident<Real>(10'000), dice, 700);
  check_equal<A>("one", coincident<Real>(1), dice, rays);
  check_equal<A>("two", coincident<Real>(2), dice, rays);
  check_equal<A>("two apart", Spheres<Real>{shape<Real>({}, 1), shape<Real>({3, 0, 0}, 1)}, dice,
                 rays);
}

template <typename A, typename Real>
void check_nothing_is_never_hit() {
  const A accelerator(Spheres<Real>{});
  Sides<Real> sides;
  sides.start({});
  Hit<Real> best;
  accelerator.enter(Ray<Real>({0, 0, 0}, {0, 0, 1}), sides, best);
  CHECK(best.sphere == no_sphere);
  CHECK(accelerator.depth() == 0);
  CHECK(accelerator.bytes() == 0);
}

/// Of spheres in one place, a path that is inside of the first few enters the next.
template <typename A, typename Real>
void check_first_of_equals_wins() {
  const A accelerator(coincident<Real>(1000));
  const Ray<Real> ray({1, 2, -5}, {0, 0, 1});
  Sides<Real> sides;
  sides.start({});
  for (std::uint32_t skipped = 0; skipped < 5; ++skipped) {
    Hit<Real> best;
    accelerator.enter(ray, sides, best);
    CHECK(best.sphere == skipped);
    sides.cross(skipped, false);
  }
}

/// Places each twenty times as far out as the one before it, 200 spheres in each: every cut peels
/// off one place only.
template <typename Real>
Spheres<Real> ever_farther() {
  Spheres<Real> spheres;
  const int distances = sizeof(Real) == sizeof(float) ? 35 : 150;
  for (int i = 0; i < distances; ++i) {
    const double x = std::pow(20, i - distances * 0.6);
    for (int copy = 0; copy < 200; ++copy) {
      spheres.push_back(shape<Real>({x, 0, 0}, x / 100));
    }
  }
  return spheres;
}

}  // namespace parray::test
