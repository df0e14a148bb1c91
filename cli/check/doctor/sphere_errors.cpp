#include "cli/check/doctor/sphere_errors.h"

#include <random>
#include <string>
#include <vector>

#include "cli/output/text.h"
#include "common/math/float_mode.h"

namespace parray::doctor {
namespace {

/// A seeded random generator. Its numbers are the same on every machine.
class Random {
 public:
  /// Returns a number in [low, high).
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

/// Returns a ray from outside to a point of the sphere's disc, away from the middle or at the rim.
template <typename Real, typename Store>
Ray<Real> aimed(Random& random, const SphereShape<Store>& sphere) {
  const auto radius = static_cast<double>(sphere.radius);
  const Vec3d center = vec_cast<double>(sphere.center);
  const double farthest = std::max(1e15 / radius, 2.0);  // the range of single precision
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

template <typename Store, typename Real>
struct Trial {
  SphereShape<Store> sphere;
  Ray<Real> ray;
};

/// Makes all rays before the first is checked. If GCC 12 (-O2) sees doubles that become floats and
/// doubles again, it may leave out the rounding; the check would then use other numbers than the
/// traced ones.
template <typename Store, typename Real>
std::vector<Trial<Store, Real>> make_trials(std::uint64_t count) {
  Random random;
  std::vector<Trial<Store, Real>> trials;
  trials.reserve(count);
  for (std::uint64_t i = 0; i < count; ++i) {
    const double radius = random.ten_to(-12, 12);
    const double offset = std::min(random.ten_to(-3, 6) * radius, 1e15);
    const SphereShape<Store> sphere{vec_cast<Store>(offset * random.direction()),
                                    static_cast<Store>(radius)};
    trials.push_back({sphere, aimed<Real>(random, sphere)});
  }
  return trials;
}

template <typename Wide, typename Store, typename Real>
double worst_of(std::uint64_t rays, std::uint64_t& hits) {
  double worst = 0;
  for (const auto& [stored, ray] : make_trials<Store, Real>(rays)) {
    const SphereShape<Real> sphere{vec_cast<Real>(stored.center), static_cast<Real>(stored.radius)};
    Real t = 0;
    // Rounding may move an origin near the surface into the sphere.
    if (distance_in_radii<Wide>(ray, sphere) > 1 && enters(ray, sphere, t)) {
      const double error = backward_error<Wide, Store>(ray, sphere, t);
      if (!(error <= worst)) worst = std::isnan(error) ? RealTraits<double>::infinity : error;
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

CheckResult check_hit_errors(const HitErrors& worst) {
  const std::string text = "f32 " + formatted("%.2g", worst.f32) + ", mixed " +
                           formatted("%.2g", worst.mixed) + ", f64 " +
                           formatted("%.2g", worst.f64) + " ulp(S) from the surface at most, in " +
                           counted(worst.hits, "hit") + " over 24 decades of radii";
  constexpr double most = 8;
  constexpr double most_mixed = 2;
  const bool good =
      worst.hits > 0 && worst.f32 <= most && worst.f64 <= most && worst.mixed <= most_mixed;
  CheckResult found =
      good ? passed(text)
           : failed(text + "; the limits are 8, 2 and 8",
                    "do not render on this machine, and please tell the developers of ParRay");
  found.facts = {
      {"f32", worst.f32}, {"mixed", worst.mixed}, {"f64", worst.f64}, {"hits", worst.hits}};
  return found;
}

}  // namespace parray::doctor
