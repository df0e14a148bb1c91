#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>

#include "common/trace/inside_stack.h"
#include "tests/support/rooms.h"
#include "tests/support/thorny_spheres.h"

/// Rays that are difficult for accelerators, each with the sides and the surface of its path.
namespace parray::test {

template <typename Real>
struct Query {
  Ray<Real> ray{{0, 0, 0}, {1, 0, 0}};
  InsideStack<Real> sides;
  Hit<Real> best;  ///< nearest exit from the spheres that the path is inside of
};

enum class QueryKind : std::uint8_t {
  from_afar,
  from_amid,
  along_axes,       ///< along axes or planes, with denormals and zeros of both signs
  on_planes,        ///< from the planes of boxes
  grazing,          ///< within a few roundings of touching a sphere
  grazing_poles,    ///< the same at the points where a sphere touches its bounds
  along_diagonals,  ///< along or across diagonals, from the planes that bound a sphere there
  on_borders,       ///< from the planes that halve cubes
  off_surface,      ///< from a surface, outwards
  from_inside,      ///< from inside a sphere
  across_inside,    ///< from the inner side of a surface, inside other spheres
};
constexpr int query_kinds = 11;

/// Makes queries about spheres that are stored as `Store` and traced as `Real`.
template <typename Real, typename Store = Real>
class Questioner {
 public:
  /// `spheres` must not be empty. Both arguments must outlive the object.
  Questioner(const Spheres<Real>& spheres, Dice& dice)
      : spheres_(spheres), dice_(dice), lo_(spheres[0].center), hi_(lo_) {
    for (const auto& [c, radius] : spheres) {
      lo_ = {min_of(lo_.x, c.x), min_of(lo_.y, c.y), min_of(lo_.z, c.z)};
      hi_ = {max_of(hi_.x, c.x), max_of(hi_.y, c.y), max_of(hi_.z, c.z)};
    }
  }

  Query<Real> next(QueryKind kind) {
    Query<Real> query;
    query.sides.start();
    if (kind >= QueryKind::off_surface) {
      from_surface_or_inside(kind, query);
      return query;
    }
    query.ray = ray(kind);
    if (dice_.one_in(4)) query.sides.stand_on(any_index(), {0, 0, 1});
    return query;
  }

 private:
  Ray<Real> ray(QueryKind kind) {
    switch (kind) {
      case QueryKind::from_afar: {
        const Vec3d target = vec_cast<double>(any().center);
        const Vec3d from = target + dice_.ten_to(0, 4) * dice_.direction();
        return aimed(from, target + static_cast<double>(any().radius) * dice_.direction());
      }
      case QueryKind::from_amid: {
        const Vec3d from = vec_cast<double>(any().center) + dice_.direction();
        return aimed(from, vec_cast<double>(any().center));
      }
      case QueryKind::along_axes: return {on_planes(), axis_direction()};
      case QueryKind::on_planes: return {on_planes(), vec_cast<Real>(dice_.direction())};
      case QueryKind::grazing: return grazing();
      case QueryKind::grazing_poles: return grazing_pole();
      case QueryKind::along_diagonals: return {on_diagonal_planes(), diagonal_direction()};
      default:
        return {on_borders(),
                dice_.one_in(2) ? axis_direction() : vec_cast<Real>(dice_.direction())};
    }
  }

  void from_surface_or_inside(QueryKind kind, Query<Real>& query) {
    const std::uint32_t index = any_index();
    const SphereShape<Real>& sphere = spheres_[index];
    const Vec3<Real> n = normalize(vec_cast<Real>(dice_.direction()));
    if (kind == QueryKind::from_inside) {
      query.ray = {sphere.center + (sphere.radius * Real(0.7)) * n,
                   vec_cast<Real>(dice_.direction())};
      enter(index, query);
      return;
    }
    const Real side = kind == QueryKind::off_surface ? 1 : -1;
    query.ray = {sphere.center + sphere.radius * n,
                 side * n + vec_cast<Real>(0.99 * dice_.direction())};
    query.sides.stand_on(index, n);
    if (kind == QueryKind::across_inside) {
      for (std::uint64_t others = dice_.below(4); others > 0; --others) enter(any_index(), query);
      enter(index, query);
    }
  }

  /// Puts the path inside a sphere unless it is inside already.
  void enter(std::uint32_t index, Query<Real>& query) const {
    if (std::count(query.sides.inside().begin(), query.sides.inside().end(), index) > 0) return;
    query.sides.cross(index, false);
    const Real t = query.sides.stands_on(index)
                       ? chord_from_surface(query.ray, spheres_[index], query.sides.normal())
                       : exit_distance(query.ray, spheres_[index]);
    if (query.best.loses_to(t, index)) query.best = {t, index, true};
  }

  std::uint32_t any_index() { return dice_.below32(static_cast<std::uint32_t>(spheres_.size())); }
  const SphereShape<Real>& any() { return spheres_[any_index()]; }

  static Ray<Real> aimed(const Vec3d& from, const Vec3d& to) {
    const Vec3<Real> origin = vec_cast<Real>(from);
    const Vec3d way = to - vec_cast<double>(origin);
    const double distance = length(way);
    return {origin, vec_cast<Real>(distance > 0 ? (1 / distance) * way : Vec3d{0, 0, 1})};
  }

  /// Returns a coordinate of a sphere, of its bounds, or of the bounds with a margin for rounding.
  Real plane(Real center, Real radius, Real size) {
    const Store margin = Store(32) * RealTraits<Store>::unit_roundoff * static_cast<Store>(size);
    const auto extent = static_cast<Store>(radius);
    const std::array<Store, 5> choices{0, extent, -extent, extent + margin, -(extent + margin)};
    return static_cast<Real>(static_cast<Store>(center) + choices[dice_.below(choices.size())]);
  }

  Vec3<Real> on_planes() {
    const auto& s = any();
    const Real size = std::max({std::abs(s.center.x), std::abs(s.center.y), std::abs(s.center.z)});
    Vec3<Real> p{plane(s.center.x, s.radius, size + s.radius),
                 plane(s.center.y, s.radius, size + s.radius),
                 plane(s.center.z, s.radius, size + s.radius)};
    if (dice_.one_in(2)) p.x = p.x - 20 * s.radius;
    return p;
  }

  Real near_zero() {
    constexpr auto denormal = static_cast<Real>(std::numeric_limits<Store>::denorm_min());
    constexpr Real least = std::numeric_limits<Real>::denorm_min();
    // The reciprocal is finite, but its product with a length overflows.
    constexpr auto edge = static_cast<Real>(Store(1.1) / std::numeric_limits<Store>::max());
    const std::array<Real, 9> values{Real(0),     -Real(0),     least, -least, -denormal,
                                     Real(1e-30), Real(-1e-30), edge,  -edge};
    return values[dice_.below(values.size())];
  }

  Vec3<Real> axis_direction() {
    const auto along = static_cast<Real>(dice_.sign());
    const auto other = dice_.one_in(3) ? static_cast<Real>(dice_.sign()) : near_zero();
    switch (dice_.below(3)) {
      case 0: return {along, other, near_zero()};
      case 1: return {near_zero(), along, other};
      default: return {other, near_zero(), along};
    }
  }

  /// Returns (+-1, +-1, +-1).
  Vec3d diagonal() {
    const double x = dice_.sign();
    const double y = dice_.sign();
    return {x, y, dice_.sign()};
  }

  /// Returns the point where a diagonal leaves a sphere's bounds, with or without a margin for
  /// rounding, moved within that plane by whole radii.
  Vec3<Real> on_diagonal_planes() {
    const auto& s = any();
    const Vec3<Real> n = vec_cast<Real>(diagonal());
    const Real size =
        std::max({std::abs(s.center.x), std::abs(s.center.y), std::abs(s.center.z)}) + s.radius;
    const Real out = plane(Real(0), s.radius / square_root(Real(3)), size);
    const auto step = static_cast<Real>(dice_.below(20)) * s.radius;
    return s.center + out * n + step * Vec3<Real>{n.x, -n.y, Real(0)};
  }

  /// Returns a diagonal, or a direction at right angles to one, except for a few roundings.
  Vec3<Real> diagonal_direction() {
    const Vec3d n = diagonal();
    if (dice_.one_in(3)) {
      const Real x = near_zero();
      const Real y = near_zero();
      return vec_cast<Real>(n) + Vec3<Real>{x, y, near_zero()};
    }
    Vec3<Real> across = dice_.one_in(2) ? vec_cast<Real>(Vec3d{n.x, -n.y, 0})
                                        : vec_cast<Real>(dice_.across(normalize(n)));
    across.z = across.z + near_zero();
    return across;
  }

  /// Returns a corner of a cube that results from repeatedly halving the cube around all centres.
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

  Ray<Real> grazing() {
    const auto& sphere = any();
    const auto radius = static_cast<double>(sphere.radius);
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

  /// Returns a ray that touches a sphere where it touches its bounds.
  Ray<Real> grazing_pole() {
    const auto& sphere = any();
    const auto radius = static_cast<double>(sphere.radius);
    const auto axis = dice_.below(4);  // 3: a diagonal
    const double side = dice_.sign();
    const Vec3d pole =
        axis == 3 ? normalize(diagonal())
                  : Vec3d{axis == 0 ? side : 0, axis == 1 ? side : 0, axis == 2 ? side : 0};
    const Vec3d touched = vec_cast<double>(sphere.center) + radius * pole;
    // From far away, or from the point nearest to the origin of coordinates, where coordinates have
    // small roundings.
    const bool from_zero = dice_.one_in(2);
    const Vec3d across = cross(pole, cross(touched, pole));
    const Vec3d level = from_zero && length(across) > 0 ? normalize(across) : dice_.across(pole);
    const Vec3d way = normalize(level + (dice_.sign() * dice_.ten_to(-12, -3)) * pole);
    const double back = from_zero ? dot(touched, way) : radius * dice_.ten_to(0, 5);
    const auto roundoff = static_cast<double>(dice_.one_in(2) ? RealTraits<Real>::unit_roundoff
                                                              : RealTraits<Store>::unit_roundoff);
    const double off = dice_.between(-4, 4) * roundoff * std::max(radius, std::abs(back));
    return {vec_cast<Real>(touched + off * pole - back * way), vec_cast<Real>(way)};
  }

  const Spheres<Real>& spheres_;
  Dice& dice_;
  Vec3<Real> lo_;  ///< lower corner of the bounds of the centres
  Vec3<Real> hi_;
};

}  // namespace parray::test
