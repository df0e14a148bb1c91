#include "cli/check/doctor/extremes.h"

#include <bit>
#include <functional>
#include <random>
#include <string>

#include "cli/output/text.h"
#include "common/base/cpu_count.h"
#include "common/image/radiance_scale.h"
#include "common/math/float_mode.h"
#include "common/scene/settings.h"

namespace parray::doctor {
namespace {

constexpr std::uint64_t one = std::uint64_t{1} << 32;  // the radiance 1 in fixed point

struct Sums {
  std::vector<PixelSums> pixels;
  TraceCounts counts;
};

Sums sums_of(const PathTracer& tracer, const RenderSettings& settings) {
  const FloatMode ieee;
  Sums sums{std::vector<PixelSums>(std::size_t{settings.width} * settings.height), {}};
  for (std::uint32_t y = 0; y < settings.height; ++y) {
    tracer.trace({y, 0, settings.width}, {0, settings.samples_per_pixel},
                 std::span(sums.pixels).subspan(std::size_t{y} * settings.width, settings.width),
                 sums.counts);
  }
  return sums;
}

bool all_are(const Sums& sums, std::uint64_t fixed, const RenderSettings& settings) {
  return sums.counts.nonfinite == 0 &&
         pixels_other_than(sums.pixels, fixed, settings.samples_per_pixel) == 0;
}

/// Returns the names of the precisions and accelerators for which `wrong` returns true.
std::string wrong_ones(RenderSettings settings,
                       const std::function<bool(const RenderSettings&)>& wrong) {
  std::string names;
  for (const Precision precision : {Precision::f32, Precision::mixed, Precision::f64}) {
    for (const AcceleratorKind accelerator : {AcceleratorKind::linear, AcceleratorKind::bvh}) {
      settings.precision = precision;
      settings.accelerator = accelerator;
      if (wrong(settings)) {
        names += (names.empty() ? "" : ", ") + std::string(name_of(precision)) + " " +
                 std::string(name_of(accelerator));
      }
    }
  }
  return names;
}

template <typename Real>
Real computed(char operation, Real first, Real second) {
  // Volatile, so that the processor computes the result and not the compiler.
  const volatile Real a = first;
  const volatile Real b = second;
  switch (operation) {
    case '+': return a + b;
    case '-': return a - b;
    case '*': return a * b;
    case '/': return a / b;
    default: return std::sqrt(a);
  }
}

template <typename Real, typename Bits>
std::size_t wrong_of(std::span<const RoundingCase<Bits>> cases) {
  std::size_t wrong = 0;
  for (const RoundingCase<Bits>& c : cases) {
    const Real result =
        computed(c.operation, std::bit_cast<Real>(c.first), std::bit_cast<Real>(c.second));
    wrong += std::bit_cast<Bits>(result) == c.result ? 0 : 1;
  }
  return wrong;
}

}  // namespace

RenderSettings sized(std::uint32_t width, std::uint32_t height, std::uint64_t samples,
                     std::uint32_t depth) {
  RenderSettings settings;
  settings.width = width;
  settings.height = height;
  settings.samples_per_pixel =
      static_cast<std::uint32_t>(std::min<std::uint64_t>(samples, 1U << 24));
  settings.max_depth = depth;
  return settings;
}

Scene under_white_sky() {
  Scene scene;
  scene.sky = {{1, 1, 1}, {1, 1, 1}};
  scene.camera.aperture = 0;
  scene.camera.tan_half_vfov = 0.5;
  return scene;
}

Scene white_balls() {
  Scene scene = under_white_sky();
  scene.camera.look_from = {0, 0, 6};
  scene.camera.tan_half_vfov = 0.4;
  scene.materials = {{MaterialType::diffuse, {1, 1, 1}, 0, 1},
                     {MaterialType::metal, {1, 1, 1}, 0, 1},
                     {MaterialType::dielectric, {1, 1, 1}, 0, 1.5},
                     {MaterialType::dielectric, {1, 1, 1}, 0, 1 / 1.5}};
  scene.spheres = {
      {{-1, 0, 0}, 1, 0}, {{1, 0, 0}, 1, 1}, {{0, 1.75, 0}, 1, 2}, {{0, 1.75, 0}, 0.875, 3}};
  return scene;
}

Scene closed_ball(double radius, double off_centre) {
  Scene scene = under_white_sky();
  scene.camera.look_from = {off_centre * radius, 0, 0};
  scene.camera.look_at = {-radius, -0.3 * radius, 0.2 * radius};
  scene.materials = {{MaterialType::diffuse, {1, 1, 1}, 0, 1}};
  scene.spheres = {{{0, 0, 0}, radius, 0}};
  return scene;
}

Scene grey_ball(double radius) {
  Scene scene = under_white_sky();
  scene.camera.look_from = {0, 0, 3 * radius};
  scene.camera.tan_half_vfov = 0.2;
  scene.materials = {{MaterialType::diffuse, {0.5, 0.5, 0.5}, 0, 1}};
  scene.spheres = {{{0, 0, 0}, radius, 0}};
  return scene;
}

Scene scaled(Scene scene, int k) {
  const auto by = [k](const Vec3d& v) {
    return Vec3d{std::ldexp(v.x, k), std::ldexp(v.y, k), std::ldexp(v.z, k)};
  };
  scene.camera.look_from = by(scene.camera.look_from);
  scene.camera.look_at = by(scene.camera.look_at);
  scene.camera.aperture = std::ldexp(scene.camera.aperture, k);
  scene.camera.focus_distance = std::ldexp(scene.camera.focus_distance, k);
  for (Sphere& sphere : scene.spheres) {
    sphere.center = by(sphere.center);
    sphere.radius = std::ldexp(sphere.radius, k);
  }
  return scene;
}

std::size_t pixels_other_than(const std::vector<PixelSums>& pixels, std::uint64_t fixed,
                              std::uint64_t samples) {
  PixelSums expected;
  expected.sum.fill(samples * fixed);
  expected.sum_of_squares.fill(samples * RadianceScale::square_of(fixed));
  expected.odd.fill(samples / 2 * fixed);
  return static_cast<std::size_t>(
      std::ranges::count_if(pixels, [&](const PixelSums& pixel) { return !(pixel == expected); }));
}

CheckResult check_furnaces(const TracerMaker& make) {
  const RenderSettings open = sized(24, 24, 8, 1U << 16);
  const RenderSettings closed = sized(8, 8, 2, 1000);
  const Scene balls = white_balls();
  const Scene ball = closed_ball(1, 0.75);
  std::uint64_t bounces = 0;
  const std::string dark = wrong_ones(open, [&](const RenderSettings& settings) {
    const Sums sums = sums_of(*make(balls, settings), settings);
    return !all_are(sums, one, settings);
  });
  const std::string leaky = wrong_ones(closed, [&](const RenderSettings& settings) {
    const Sums sums = sums_of(*make(ball, settings), settings);
    bounces += sums.counts.rays;
    return !all_are(sums, 0, settings) ||
           sums.counts.rays != sums.counts.samples * settings.max_depth;
  });
  if (dark.empty() && leaky.empty()) {
    return passed("white furnace exactly 1, closed ball exactly 0 after " +
                  with_unit(static_cast<double>(bounces), "bounces"));
  }
  return failed(
      (dark.empty() ? "" : "white furnace not exactly 1 in " + dark) +
          (dark.empty() || leaky.empty() ? "" : "; ") +
          (leaky.empty() ? "" : "closed ball not exactly 0, or paths end early, in " + leaky),
      wrong_bits);
}

CheckResult check_self_hits(const TracerMaker& make) {
  const Scene ball = grey_ball(1);
  std::uint64_t paths = 0;
  const std::string wrong = wrong_ones(sized(32, 32, 16, 50), [&](const RenderSettings& settings) {
    const Sums sums = sums_of(*make(ball, settings), settings);
    paths += sums.counts.samples;
    return sums.counts.rays != 2 * sums.counts.samples || !all_are(sums, one / 2, settings);
  });
  return wrong.empty()
             ? passed("none in " + counted(paths, "path"))
             : failed("paths hit the surface that they leave, or samples are not exactly 1/2, in " +
                          wrong,
                      wrong_bits);
}

CheckResult check_scaling(const TracerMaker& make) {
  const Scene scene = doctor_scene().scene;
  const std::string wrong = wrong_ones(sized(24, 24, 2, 12), [&](const RenderSettings& settings) {
    const auto expected = sums_of(*make_scalar_tracer(scene, settings), settings).pixels;
    const auto differs = [&](int k) {
      const Scene here = scaled(scene, k);
      return sums_of(*make(here, settings), settings).pixels != expected;
    };
    return differs(-40) || differs(0) || differs(40);
  });
  return wrong.empty()
             ? passed("scenes scaled by 2^-40, 1 and 2^40 give exactly the defined bits")
             : failed("a scaled scene does not give the defined bits in " + wrong, wrong_bits);
}

CheckResult check_rounding(std::span<const RoundingCase<std::uint32_t>> singles,
                           std::span<const RoundingCase<std::uint64_t>> doubles) {
  std::size_t wrong_singles = 0;
  std::size_t wrong_doubles = 0;
#pragma omp parallel num_threads(usable_cpus()) reduction(+ : wrong_singles, wrong_doubles)
  {
    const FloatMode ieee;
    wrong_singles += wrong_of<float>(singles);
    wrong_doubles += wrong_of<double>(doubles);
  }
  const std::string cases = counted(singles.size() + doubles.size(), "hard case");
  if (wrong_singles + wrong_doubles == 0) {
    return passed("+ - x / sqrt are correctly rounded in f32 and f64 (" + cases + ")");
  }
  return failed("wrong results of + - x / sqrt: " + std::to_string(wrong_singles) + " in f32, " +
                    std::to_string(wrong_doubles) + " in f64, over all threads (" + cases + ")",
                "do not render on this machine: its processor or emulator violates IEEE 754");
}

// ---- Hits on spheres -------------------------------------------------------------------------

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
