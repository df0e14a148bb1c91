#include "common/scene/requirements.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <limits>

#include "common/scene/origin.h"

namespace parray {
namespace {

/// Largest spread that single precision carries: rounding of a coordinate then stays below
/// 2^16 * 2^-24 = 1/256 of the smallest radius. Where only what is computed exceeds it (a small
/// sphere on a huge one), storing in single precision still does: mixed.
constexpr double largest_f32_spread = 0x1p16;

/// Spheres up to which trying all is at least as fast as the tree [measured by tests/bench/one-core
/// on One Weekend scenes: f32 is even at 64, mixed and f64 at 32].
std::size_t largest_linear(Precision precision) { return precision == Precision::f32 ? 56 : 32; }

double largest_component(const Vec3d& v) {
  return std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)});
}

std::string number(double value) {
  std::array<char, 32> text{};
  const int length = std::snprintf(text.data(), text.size(), "%.3g", value);
  return {text.data(), static_cast<std::size_t>(length)};
}

}  // namespace

double Requirements::spread() const { return spheres == 0 ? 0 : extent / smallest_radius; }

std::vector<std::string> Requirements::features() const {
  std::vector<std::string> names;
  const auto add = [&](bool present, const char* name) {
    if (present) {
      names.emplace_back(name);
    }
  };
  add(diffuse > 0, "diffuse");
  add(metal > 0, "metal");
  add(fuzz, "fuzz");
  add(dielectric > 0, "dielectric");
  add(lens, "lens");
  add(spheres > 0 && !one_radius, "many-radii");
  return names;
}

Requirements requirements_of(const Scene& scene) {
  Requirements result;
  result.spheres = scene.spheres.size();
  result.lens = scene.camera.aperture > 0;
  const Vec3d origin = scene_origin(scene);
  result.extent = largest_component(scene.camera.look_from - origin) + scene.camera.aperture / 2;
  double smallest = std::numeric_limits<double>::infinity();
  for (const Sphere& sphere : scene.spheres) {
    const Material& material = scene.materials[sphere.material];
    result.diffuse += material.type == MaterialType::diffuse ? 1U : 0U;
    result.metal += material.type == MaterialType::metal ? 1U : 0U;
    result.dielectric += material.type == MaterialType::dielectric ? 1U : 0U;
    result.fuzz = result.fuzz || (material.type == MaterialType::metal && material.fuzz > 0);
    smallest = std::min(smallest, sphere.radius);
    result.largest_radius = std::max(result.largest_radius, sphere.radius);
    result.own_spread =
        std::max(result.own_spread, largest_component(sphere.center - origin) / sphere.radius);
    result.extent =
        std::max(result.extent, largest_component(sphere.center - origin) + sphere.radius);
  }
  result.smallest_radius = scene.spheres.empty() ? 0 : smallest;
  result.one_radius = !scene.spheres.empty() && smallest == result.largest_radius;
  return result;
}

namespace {

void decide_precision(const Requirements& requirements, ResolvedSettings& result) {
  const double spread = requirements.spread();
  const bool single = spread <= largest_f32_spread;
  result.precision_reason = "extent / smallest radius = " + number(spread) +
                            (single ? ", at most " : ", more than ") + number(largest_f32_spread);
  result.settings.precision = Precision::f32;
  if (!single) {
    const bool stored = requirements.own_spread <= largest_f32_spread;
    result.precision_reason += "; coordinate / own radius = " + number(requirements.own_spread) +
                               (stored ? ", at most that" : ", more than that");
    result.settings.precision = stored ? Precision::mixed : Precision::f64;
  }
}

}  // namespace

ResolvedSettings resolve_settings(const Requirements& requirements, const RenderSettings& asked) {
  ResolvedSettings result{asked, "asked for", "asked for"};
  RenderSettings& settings = result.settings;
  if (settings.precision == Precision::automatic) {
    decide_precision(requirements, result);
  }
  if (settings.accelerator == AcceleratorKind::automatic) {
    const std::size_t most = largest_linear(settings.precision);
    const bool few = requirements.spheres <= most;
    settings.accelerator = few ? AcceleratorKind::linear : AcceleratorKind::bvh;
    result.accelerator_reason = std::to_string(requirements.spheres) +
                                (few ? " spheres, at most " : " spheres, more than ") +
                                std::to_string(most);
  }
  if (settings.row_order == RowOrder::automatic) {
    settings.row_order = settings.schedule == SchedulePolicy::weighted ? RowOrder::interleaved
                                                                       : RowOrder::sequential;
  }
  return result;
}

}  // namespace parray
