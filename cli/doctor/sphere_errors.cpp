#include "cli/doctor/sphere_errors.h"

#include <random>
#include <string>

#include "cli/text.h"
#include "common/math/float_mode.h"

namespace parray {
namespace {

/// Seeded, and the same on every machine.
class Random {
 public:
  /// [low, high)
  double between(double low, double high) {
    return low + (high - low) * (static_cast<double>(engine_() >> 11) * 0x1p-53);
  }
  double ten_to(double low, double high) { return std::pow(10, between(low, high)); }
  Vec3d direction() {
    for (;;) {
      const double x = between(-1, 1);
      const double y = between(-1, 1);
      const Vec3d v{x, y, between(-1, 1)};
      const double square = dot(v, v);
      if (square > 0.01 && square <= 1) return (1 / std::sqrt(square)) * v;
    }
  }

 private:
  std::mt19937_64 engine_{1};
};

/// A ray from outside that is aimed at a point of the sphere's disc, off the middle or at the rim.
template <typename Real>
Ray<Real> aimed(Random& random, const SphereShape<Real>& sphere) {
  const auto radius = static_cast<double>(sphere.radius);
  const Vec3d center = vec_cast<double>(sphere.center);
  const double farthest = std::max(1e15 / radius, 2.0);  // as far as single precision reaches
  const double distance = std::min(random.ten_to(0.01, 6), farthest);
  const Vec3<Real> origin = vec_cast<Real>(center + (distance * radius) * random.direction());
  const Vec3d axis = center - vec_cast<double>(origin);
  const Vec3d across = normalize(cross(axis, random.direction()));
  const double impact =
      random.between(0, 1) < 0.5 ? random.between(0, 1) : 1 - random.ten_to(-12, -1);
  const double sine = std::min(impact * radius / length(axis), 1.0);
  const Vec3d aim = std::sqrt(1 - sine * sine) * normalize(axis) + sine * across;
  return {origin, vec_cast<Real>(aim)};
}

template <typename Wide, typename Store, typename Real>
double worst_of(std::uint64_t rays, std::uint64_t& hits) {
  Random random;
  double worst = 0;
  for (std::uint64_t i = 0; i < rays; ++i) {
    const double radius = random.ten_to(-12, 12);
    const double offset = std::min(random.ten_to(-3, 6) * radius, 1e15);
    const Vec3<Store> center = vec_cast<Store>(offset * random.direction());
    const SphereShape<Real> sphere{vec_cast<Real>(center),
                                   static_cast<Real>(static_cast<Store>(radius))};
    const Ray<Real> ray = aimed(random, sphere);
    Real t = 0;
    if (enters(ray, sphere, t)) {
      const double error = backward_error<Wide, Store>(ray, sphere, t);
      worst = error <= worst ? worst : error;  // NaN counts, too
      ++hits;
    }
  }
  return worst;
}

}  // namespace

HitErrors worst_hit_errors(std::uint64_t rays) {
  const FloatMode ieee;
  HitErrors worst;
  worst.f32 = worst_of<double, float, float>(rays, worst.hits);
  worst.mixed = worst_of<long double, float, double>(rays, worst.hits);
  worst.f64 = worst_of<long double, double, double>(rays, worst.hits);
  return worst;
}

Finding check_hit_errors(const HitErrors& worst) {
  const std::string text = "f32 " + formatted("%.2f", worst.f32) + ", mixed " +
                           formatted("%.2f", worst.mixed) + ", f64 " +
                           formatted("%.2f", worst.f64) + " ulp(S) off the surface at most, in " +
                           counted(worst.hits, "hit") + " over 24 decades of radii";
  constexpr double most = 8;
  constexpr double most_mixed = 2;
  const bool good =
      worst.hits > 0 && worst.f32 <= most && worst.f64 <= most && worst.mixed <= most_mixed;
  Finding found = good ? passed(text)
                       : failed(text + "; allowed are 8, 2 and 8",
                                "do not render on this machine: please report it");
  found.facts = {
      {"f32", worst.f32}, {"mixed", worst.mixed}, {"f64", worst.f64}, {"hits", worst.hits}};
  return found;
}

}  // namespace parray
