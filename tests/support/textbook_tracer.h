#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <random>
#include <utility>
#include <vector>

#include "common/scene/scene.h"
#include "tests/support/rooms.h"

/// Pictures as means of blocks with their errors, and a simple tracer that shares no code with
/// ParRay's tracer.
namespace parray::test {

inline constexpr std::uint32_t picture_width = 48;
inline constexpr std::uint32_t picture_height = 32;
inline constexpr std::uint32_t block = 8;

/// Mean and squared standard error of one channel of one block.
struct Estimate {
  double mean = 0;
  double error_squared = 0;
};
using Picture = std::vector<Estimate>;

/// Adds up the samples of each pixel, then the pixels of each block.
class Accumulator {
 public:
  void add(std::uint32_t x, std::uint32_t y, const std::array<double, 3>& mean,
           const std::array<double, 3>& mean_square, double samples) {
    for (std::size_t c = 0; c < 3; ++c) {
      Estimate& e = blocks_[(std::size_t{y / block} * (picture_width / block) + x / block) * 3 + c];
      e.mean += mean[c] / (block * block);
      const double variance = std::max(mean_square[c] - mean[c] * mean[c], 0.0);
      e.error_squared += variance / samples / (block * block * block * block);
    }
  }
  Picture take() { return std::move(blocks_); }

 private:
  Picture blocks_ = Picture(3UL * (picture_width / block) * (picture_height / block));
};

/// Returns the largest difference of two pictures, in standard errors of the difference.
inline double worst_deviation(const Picture& a, const Picture& b) {
  double worst = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    const double error = std::sqrt(a[i].error_squared + b[i].error_squared);
    // The rounding to single precision, for blocks without variance (sky).
    worst = std::max(worst, std::abs(a[i].mean - b[i].mean) / (error + 1e-6));
  }
  return worst;
}

/// Quadratic formula, t_min, library random numbers and trigonometry, all in double precision.
class TextbookTracer {
 public:
  /// `t_min` is that of the book "Ray Tracing in One Weekend": the tracer ignores nearer crossings.
  TextbookTracer(const Scene& scene, std::uint32_t max_depth, double t_min = 1e-7)
      : scene_(scene), max_depth_(max_depth), t_min_(t_min), random_(20240229) {}

  Picture render(int samples) {
    Accumulator result;
    for (std::uint32_t y = 0; y < picture_height; ++y) {
      for (std::uint32_t x = 0; x < picture_width; ++x) {
        std::array<double, 3> sum{};
        std::array<double, 3> square{};
        for (int s = 0; s < samples; ++s) {
          const Vec3d value = sample(x, y);
          const std::array<double, 3> rgb{value.x, value.y, value.z};
          for (std::size_t c = 0; c < 3; ++c) {
            sum[c] += rgb[c] / samples;
            square[c] += rgb[c] * rgb[c] / samples;
          }
        }
        result.add(x, y, sum, square, samples);
      }
    }
    return result.take();
  }

 private:
  double uniform() { return std::uniform_real_distribution<>(0, 1)(random_); }
  Vec3d in_ball() {
    for (;;) {
      const Vec3d p{2 * uniform() - 1, 2 * uniform() - 1, 2 * uniform() - 1};
      if (dot(p, p) <= 1 && dot(p, p) > 1e-12) return p;
    }
  }

  Vec3d sample(std::uint32_t x, std::uint32_t y) {
    const Camera& c = scene_.camera;
    const double half = std::tan(c.vfov * std::acos(-1.0) / 360);
    const Vec3d w = normalize(c.look_from - c.look_at);
    const Vec3d u = normalize(cross(c.up, w));
    const Vec3d v = cross(w, u);
    const double right =
        (2 * (x + uniform()) / picture_width - 1) * half * picture_width / picture_height;
    const double up = (1 - 2 * (y + uniform()) / picture_height) * half;
    const double angle = 2 * std::acos(-1.0) * uniform();
    const double radius = c.aperture / 2 * std::sqrt(uniform());
    const Vec3d offset = radius * std::cos(angle) * u + radius * std::sin(angle) * v;
    const Vec3d target = c.focus_distance * (right * u + up * v - w);
    return radiance(c.look_from + offset, target - offset);
  }

  const Sphere* nearest(const Vec3d& origin, const Vec3d& direction, double& t) const {
    const Sphere* hit = nullptr;
    t = 1e300;
    for (const Sphere& sphere : scene_.spheres) {
      const Vec3d oc = origin - sphere.center;
      const double a = dot(direction, direction);
      const double b = dot(oc, direction);
      const double discriminant = b * b - a * (dot(oc, oc) - sphere.radius * sphere.radius);
      if (discriminant < 0) continue;
      for (const double root :
           {(-b - std::sqrt(discriminant)) / a, (-b + std::sqrt(discriminant)) / a}) {
        if (root > t_min_ && root < t) {
          t = root;
          hit = &sphere;
        }
      }
    }
    return hit;
  }

  Vec3d radiance(Vec3d origin, Vec3d direction) {
    Vec3d throughput{1, 1, 1};
    for (std::uint32_t depth = 0; depth < max_depth_; ++depth) {
      double t = 0;
      const Sphere* sphere = nearest(origin, direction, t);
      const Vec3d unit = normalize(direction);
      if (sphere == nullptr) {
        const double h = 0.5 * (unit.y + 1);
        return throughput * ((1 - h) * scene_.sky.horizon + h * scene_.sky.zenith);
      }
      origin = origin + t * direction;
      Vec3d n = normalize(origin - sphere->center);
      const bool front = dot(n, unit) < 0;
      n = front ? n : -n;
      const Material& m = scene_.materials[sphere->material];
      if (m.type == MaterialType::diffuse) {
        direction = n + normalize(in_ball());
        throughput = throughput * m.albedo;
      } else if (m.type == MaterialType::metal) {
        direction = unit - 2 * dot(unit, n) * n + m.fuzz * in_ball();
        throughput = throughput * m.albedo;
        if (dot(direction, n) <= 0) return {};
      } else {
        direction = through_glass(unit, n, front ? 1 / m.ior : m.ior, m.ior);
      }
    }
    return {};
  }

  Vec3d through_glass(const Vec3d& unit, const Vec3d& n, double eta, double ior) {
    const double cosine = std::min(-dot(unit, n), 1.0);
    const double sine = std::sqrt(1 - cosine * cosine);
    const double r0 = std::pow((1 - ior) / (1 + ior), 2);
    const double reflectance = r0 + (1 - r0) * std::pow(1 - cosine, 5);
    if (eta * sine > 1 || uniform() < reflectance) return unit - 2 * dot(unit, n) * n;
    const Vec3d across = eta * (unit + cosine * n);
    return across - std::sqrt(std::abs(1 - dot(across, across))) * n;
  }

  const Scene& scene_;
  std::uint32_t max_depth_;
  double t_min_;
  std::mt19937_64 random_;
};

}  // namespace parray::test
