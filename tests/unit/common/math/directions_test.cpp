#include "common/math/directions.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <vector>

#include "common/trace/integrator/random.h"
#include "tests/support/dice.h"
#include "tests/support/rooms.h"
#include "tests/support/statistics.h"

namespace parray {
namespace {

using test::bin_of;
using test::z_limit;
using test::z_score;

constexpr long double two_pi = 2 * std::numbers::pi_v<long double>;

/// The ends of what a random number can be, and the middle.
constexpr std::array<double, 6> edges{0, 0x1p-24, 0.5 - 0x1p-24, 0.5, 0.5 + 0x1p-24, 1 - 0x1p-24};

/// Largest error of sincos_2pi() at `u`, in ulp of 1.
template <typename Real>
double turn_error(Real u) {
  const CosSin<Real> got = sincos_2pi(u);
  const long double angle = two_pi * u;
  const long double error =
      std::max(std::abs(std::cos(angle) - got.cos), std::abs(std::sin(angle) - got.sin));
  return static_cast<double>(error /
                             (2 * static_cast<long double>(RealTraits<Real>::unit_roundoff)));
}

template <typename Real>
double length_error(const Vec3<Real>& v) {
  const auto x = static_cast<long double>(v.x);
  const auto y = static_cast<long double>(v.y);
  const auto z = static_cast<long double>(v.z);
  const long double error = std::abs(std::sqrt(x * x + y * y + z * z) - 1);
  return static_cast<double>(error /
                             (2 * static_cast<long double>(RealTraits<Real>::unit_roundoff)));
}

/// Angle of (x, y) as a fraction of a turn in [0, 1].
double turns_of(double x, double y) { return std::atan2(y, x) / (2 * std::numbers::pi) + 0.5; }

/// First and second moments of a vector whose components should have mean 0, variance `variance`
/// and fourth moment `fourth`, and be uncorrelated with E[x^2 y^2] = `mixed`.
class Moments {
 public:
  void add(const Vec3d& v) {
    const std::array<double, 3> c{v.x, v.y, v.z};
    for (std::size_t i = 0; i < 3; ++i) {
      first_[i] += c[i];
      second_[i] += c[i] * c[i];
      products_[i] += c[i] * c[(i + 1) % 3];
    }
    ++count_;
  }
  [[nodiscard]] double worst_z(double variance, double fourth, double mixed) const {
    double worst = 0;
    for (std::size_t i = 0; i < 3; ++i) {
      worst =
          std::max({worst, std::abs(z_score(first_[i], count_, 0, variance)),
                    std::abs(z_score(second_[i], count_, variance, fourth - variance * variance)),
                    std::abs(z_score(products_[i], count_, 0, mixed))});
    }
    return worst;
  }

 private:
  std::array<double, 3> first_{};
  std::array<double, 3> second_{};
  std::array<double, 3> products_{};
  double count_ = 0;
};

/// Counts of points over cells of equal probability.
class Cells {
 public:
  explicit Cells(std::size_t side) : side_(side), counts_(side * side) {}
  void add(double a, double b) { counts_[bin_of(a, side_) * side_ + bin_of(b, side_)] += 1; }
  [[nodiscard]] double z() const { return test::chi_square_z(counts_); }

 private:
  std::size_t side_;
  std::vector<double> counts_;
};

constexpr std::uint32_t draws = 400'000;

template <typename Real>
Uniform4<Real> draw(std::uint32_t i, Purpose purpose = Purpose::scatter) {
  return SampleRandom(4, i, 0).at<Real>(0, purpose);
}

}  // namespace

TEST_CASE("turn is cosine and sine to 2 ulp of 1 in single precision, for every 24-bit number") {
  double worst = 0;
  for (std::uint32_t i = 0; i < 1U << 24; i += 7) {
    worst = std::max(worst, turn_error(static_cast<float>(i) * 0x1p-24F));
  }
  CHECK(worst <= 2);
  CHECK(worst > 0);
}

TEST_CASE("turn is cosine and sine to 2 ulp of 1 in double precision") {
  test::Dice dice(1);
  double worst = 0;
  for (int i = 0; i < 500'000; ++i) {
    worst = std::max(worst, turn_error(dice.unit()));
    worst = std::max(worst, turn_error(static_cast<double>(dice.below(1U << 24)) * 0x1p-24));
  }
  CHECK(worst <= 2);
  CHECK(worst > 0);
}

TEST_CASE_TEMPLATE("turn is exact at the quarter turns and within bounds around them", Real, float,
                   double) {
  CHECK(sincos_2pi(Real(0)).cos == 1);
  CHECK(sincos_2pi(Real(0)).sin == 0);
  CHECK(sincos_2pi(Real(0.25)).cos == 0);
  CHECK(sincos_2pi(Real(0.25)).sin == 1);
  CHECK(sincos_2pi(Real(0.5)).cos == -1);
  CHECK(sincos_2pi(Real(0.5)).sin == 0);
  CHECK(sincos_2pi(Real(0.75)).cos == 0);
  CHECK(sincos_2pi(Real(0.75)).sin == -1);
  for (int eighth = 0; eighth < 8; ++eighth) {  // odd ones: where the quadrant changes
    for (int step = -64; step <= 64; ++step) {
      const Real u = static_cast<Real>(eighth) / 8 + static_cast<Real>(step) * Real(0x1p-24);
      if (u >= 0) CHECK(turn_error(u) <= 2);
    }
  }
}

TEST_CASE_TEMPLATE("a uniform direction has unit length", Real, float, double) {
  double worst = 0;
  for (const double u : edges) {
    for (const double v : edges) {
      worst = std::max(worst,
                       length_error(uniform_direction(static_cast<Real>(u), static_cast<Real>(v))));
    }
  }
  for (std::uint32_t i = 0; i < draws; ++i) {
    const auto u = draw<Real>(i);
    worst = std::max(worst, length_error(uniform_direction(u.a, u.b)));
  }
  CHECK(worst <= 2);
}

TEST_CASE("a uniform direction is uniform on the sphere") {
  Moments moments;
  Cells cells(20);
  for (std::uint32_t i = 0; i < draws; ++i) {
    const auto u = draw<float>(i);
    const Vec3d d = vec_cast<double>(uniform_direction(u.a, u.b));
    moments.add(d);
    cells.add((d.y + 1) / 2, turns_of(d.z, d.x));
  }
  CHECK(moments.worst_z(1.0 / 3, 1.0 / 5, 1.0 / 15) < z_limit);
  CHECK(std::abs(cells.z()) < z_limit);
}

TEST_CASE("the poles of a uniform direction are where their number says") {
  CHECK(uniform_direction(0.0F, 0.3F) == Vec3<float>{0, 1, 0});
  const Vec3<float> south = uniform_direction(1 - 0x1p-24F, 0.3F);
  CHECK(south.y == -1 + 0x1p-23F);
  CHECK(std::hypot(south.x, south.z) == doctest::Approx(0x1p-11).epsilon(1e-6));
}

TEST_CASE("a point of the ball is uniform in volume and direction") {
  Moments moments;
  Cells direction(12);
  Cells shell(16);
  double largest = 0;
  for (std::uint32_t i = 0; i < draws; ++i) {
    const auto u = draw<float>(i);
    const auto r = draw<float>(i, Purpose::fuzz);
    const Vec3d p = vec_cast<double>(uniform_ball(u.a, u.b, r.a, r.b, r.c));
    const double radius = length(p);
    largest = std::max(largest, radius);
    moments.add(p);
    direction.add((p.z / radius + 1) / 2, turns_of(p.x, p.y));
    shell.add(radius * radius * radius, (p.x / radius + 1) / 2);
  }
  CHECK(moments.worst_z(1.0 / 5, 3.0 / 35, 1.0 / 35) < z_limit);
  CHECK(std::abs(direction.z()) < z_limit);
  CHECK(std::abs(shell.z()) < z_limit);  // radius^3 uniform, and independent of the direction
  CHECK(largest <= 1 + 0x1p-22);
}

TEST_CASE("a point of the disc is uniform in area") {
  Cells cells(20);
  double x = 0;
  double y = 0;
  double xx = 0;
  double xy = 0;
  double largest = 0;
  for (std::uint32_t i = 0; i < draws; ++i) {
    const auto u = draw<float>(i, Purpose::camera);
    const Disc<float> p = uniform_disc(u.c, u.d);
    const double px = static_cast<double>(p.x);
    const double py = static_cast<double>(p.y);
    const double square = px * px + py * py;
    largest = std::max(largest, square);
    cells.add(square, turns_of(px, py));
    x += px;
    y += py;
    xx += px * px;
    xy += px * py;
  }
  CHECK(std::abs(cells.z()) < z_limit);
  CHECK(std::abs(z_score(x, draws, 0, 1.0 / 4)) < z_limit);
  CHECK(std::abs(z_score(y, draws, 0, 1.0 / 4)) < z_limit);
  CHECK(std::abs(z_score(xx, draws, 1.0 / 4, 1.0 / 8 - 1.0 / 16)) < z_limit);
  CHECK(std::abs(z_score(xy, draws, 0, 1.0 / 24)) < z_limit);
  CHECK(largest <= 1 + 0x1p-22);
}

TEST_CASE("squares become circles on the disc, and neighbours stay such") {
  test::Dice dice(2);
  double farthest = 0;
  for (int i = 0; i < 100'000; ++i) {
    const double u = dice.unit();
    const double v = dice.unit();
    const Disc<double> p = uniform_disc(u, v);
    const double square = 2 * std::max(std::abs(u - 0.5), std::abs(v - 0.5));
    CHECK(std::abs(std::hypot(p.x, p.y) - square) < 1e-15);
    const double turn = 0.1 * (dice.unit() - 0.5);
    const Disc<double> q = uniform_disc(std::clamp(u + turn, 0.0, 1.0), v);
    farthest = std::max(farthest, std::hypot(p.x - q.x, p.y - q.y) / std::abs(turn));
  }
  CHECK(farthest < 3);  // of the map by radius and angle: any
}

TEST_CASE_TEMPLATE("the ends of the random numbers give finite points of ball and disc", Real,
                   float, double) {
  for (const double a : edges) {
    for (const double b : edges) {
      const Real u = static_cast<Real>(a);
      const Real v = static_cast<Real>(b);
      const Disc<Real> p = uniform_disc(u, v);
      CHECK(p.x * p.x + p.y * p.y <= 1 + 8 * RealTraits<Real>::unit_roundoff);
      for (const double c : edges) {
        const Vec3<Real> q = uniform_ball(u, v, Real(0), static_cast<Real>(c), Real(0));
        CHECK(std::abs(length(q) - static_cast<Real>(c)) <= 8 * RealTraits<Real>::unit_roundoff);
      }
    }
  }
  CHECK(uniform_ball(Real(0.3), Real(0.7), Real(0), Real(0), Real(0)) == Vec3<Real>{});
  CHECK(uniform_disc(Real(0.5), Real(0.5)).x == 0);
  CHECK(uniform_disc(Real(0.5), Real(0.5)).y == 0);
}

}  // namespace parray
