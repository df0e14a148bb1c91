#include "common/scene/requirements.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <limits>

#include "common/base/bands.h"
#include "common/math/largest_component.h"
#include "common/scene/origin.h"
#include "common/scene/setting_choices.h"
#include "common/scene/settings.h"

namespace parray::scene {
namespace {

/// Largest shifts of surfaces that stay invisible, as parts of the smallest radius (particles
/// smaller than a pixel keep their cross-section) and of the picture's height at the nearest
/// surface. Source: tests/extremes/precision_test.cpp [measured: 2^-5 and 2^-12.5 are the smallest
/// visible shifts].
constexpr double share_of_radius = 0x1p-8;
constexpr double share_of_view = 0x1p-13;

/// Number of spheres up to which testing all is at least as fast as the tree [measured by
/// tests/bench/one-core on One Weekend scenes: f32 is even at 64, mixed and f64 at 32].
std::size_t largest_linear(Precision precision) { return precision == Precision::f32 ? 48 : 28; }

std::string number(double value) {
  std::array<char, 32> text{};
  const int length = std::snprintf(text.data(), text.size(), "%.3g", value);
  return {text.data(), static_cast<std::size_t>(length)};
}

/// Returns a part as text: "1/4096" of something, "less than a millionth", "3.5 times" it.
std::string share(double value) {
  if (value >= 1) return number(value) + " times";
  if (value < 1e-6) return "less than a millionth of";
  return "1/" + std::to_string(std::lround(1 / value)) + " of";
}

/// Returns the change of a number by storing it in single precision.
double single_precision_shift(double x) {
  return std::abs(static_cast<double>(static_cast<float>(x)) - x);
}

double single_precision_shift(const Vec3d& v) {
  return std::max(
      {single_precision_shift(v.x), single_precision_shift(v.y), single_precision_shift(v.z)});
}

/// Update extent, stored_shift and nearest with a shape. All positions are relative to the scene's
/// origin.
void add_conditioning(const Sphere& sphere, const Vec3d& eye, Requirements& result) {
  const Vec3d center = sphere.center - result.origin;
  result.extent = std::max(result.extent, largest_component(center));
  result.stored_shift = std::max(result.stored_shift, single_precision_shift(center));
  result.nearest = std::min(result.nearest, std::abs(length(center - eye) - sphere.radius));
}
void add_conditioning(const Capsule& capsule, const Vec3d& eye, Requirements& result) {
  const Vec3d from = capsule.from - result.origin;
  const Vec3d to = capsule.to - result.origin;
  const Vec3d half = 0.5 * (to - from);
  const Vec3d middle = from + half;
  const Vec3d nearest = middle + nearest_in_segment(half, eye - middle);
  result.extent = std::max({result.extent, largest_component(from), largest_component(to)});
  result.stored_shift =
      std::max(result.stored_shift, single_precision_shift(middle) + single_precision_shift(half));
  result.nearest = std::min(result.nearest, std::abs(length(nearest - eye) - capsule.radius));
}

void add_shape(const auto& shape, const Scene& scene, const Vec3d& eye, Requirements& result) {
  const Material& material = scene.materials[shape.material];
  result.diffuse += material.type == MaterialType::diffuse ? 1U : 0U;
  result.metal += material.type == MaterialType::metal ? 1U : 0U;
  result.dielectric += material.type == MaterialType::dielectric ? 1U : 0U;
  result.fuzz = result.fuzz || (material.type == MaterialType::metal && material.fuzz > 0);
  result.smallest_radius = std::min(result.smallest_radius, shape.radius);
  result.largest_radius = std::max(result.largest_radius, shape.radius);
  result.extent = std::max(result.extent, shape.radius);
  result.stored_shift = std::max(result.stored_shift, single_precision_shift(shape.radius));
  add_conditioning(shape, eye, result);
}

/// Adds the shapes of `part` to `whole`: counts and extremes, independent of the order.
void add_part(const Requirements& part, Requirements& whole) {
  whole.diffuse += part.diffuse;
  whole.metal += part.metal;
  whole.dielectric += part.dielectric;
  whole.fuzz = whole.fuzz || part.fuzz;
  whole.smallest_radius = std::min(whole.smallest_radius, part.smallest_radius);
  whole.largest_radius = std::max(whole.largest_radius, part.largest_radius);
  whole.extent = std::max(whole.extent, part.extent);
  whole.stored_shift = std::max(whole.stored_shift, part.stored_shift);
  whole.nearest = std::min(whole.nearest, part.nearest);
}

void add_shapes(const auto& shapes, const Scene& scene, const Vec3d& eye, int threads,
                Requirements& result) {
  const Bands bands(shapes.size(), threads);
  std::vector<Requirements> parts(bands.count());
  bands.run([&](std::size_t band, std::size_t begin, std::size_t end) {
    Requirements part;
    part.origin = result.origin;
    part.smallest_radius = part.nearest = std::numeric_limits<double>::infinity();
    for (std::size_t i = begin; i < end; ++i) add_shape(shapes[i], scene, eye, part);
    parts[band] = part;
  });
  for (const Requirements& part : parts) add_part(part, result);
}

/// A shift of surfaces relative to the length that limits it most.
struct Sight {
  double shift;
  double part;   ///< shift as a part of `whole`
  double limit;  ///< largest invisible part
  const char* whole;

  [[nodiscard]] bool invisible() const { return part <= limit; }
  /// Returns text such as "6e-05, 1/3355 of the smallest radius (invisible up to 1/256)".
  [[nodiscard]] std::string text() const {
    return number(shift) + ", " + share(part) + " " + whole + " (invisible up to 1/" +
           std::to_string(std::lround(1 / limit)) + ")";
  }
};

Sight sight_of(double shift, const Requirements& r) {
  // An eye on a surface sees every shift except 0.
  const auto part = [shift](double whole) { return shift > 0 ? shift / whole : 0; };
  const Sight radius{shift, part(r.smallest_radius), share_of_radius, "the smallest radius"};
  const Sight view{shift, part(r.view_height), share_of_view,
                   "the picture's height at the nearest surface"};
  return view.part / view.limit > radius.part / radius.limit ? view : radius;
}

void decide_precision(const Requirements& r, ResolvedSettings& result) {
  result.settings->precision = Precision::f32;
  if (r.shapes() == 0) {
    result.precision_reason = "no shapes";
    return;
  }
  const Sight computed = sight_of(r.computed_shift(), r);
  const Sight stored = sight_of(r.stored_shift, r);
  if (computed.invisible()) {
    result.precision_reason =
        "computing in single precision moves surfaces by up to " + computed.text();
  } else if (stored.invisible()) {
    result.settings->precision = Precision::mixed;
    result.precision_reason = "computing in single precision would move surfaces by up to " +
                              computed.text() + "; storing in it moves them by " +
                              number(stored.shift);
  } else {
    result.settings->precision = Precision::f64;
    result.precision_reason =
        "storing in single precision would move surfaces by up to " + stored.text();
  }
}

}  // namespace

std::vector<std::string> Requirements::features() const {
  std::vector<std::string> names;
  const auto add = [&](bool present, const char* name) {
    if (present) names.emplace_back(name);
  };
  add(diffuse > 0, "diffuse");
  add(metal > 0, "metal");
  add(fuzz, "fuzz");
  add(dielectric > 0, "dielectric");
  add(lens, "lens");
  add(shapes() > 0 && !one_radius, "many-radii");
  add(capsules > 0, "capsules");
  return names;
}

Requirements requirements_of(const Scene& scene, int threads) {
  Requirements result;
  result.spheres = scene.spheres.size();
  result.capsules = scene.capsules.size();
  result.lens = scene.camera.aperture > 0;
  result.origin = scene_origin(scene, threads);
  const Vec3d eye = scene.camera.look_from - result.origin;
  // The rays of an orthographic camera begin all over the picture, which counts as a square here.
  result.extent = largest_component(eye) + scene.camera.view_height / 2 + scene.camera.aperture / 2;
  result.smallest_radius = result.nearest = std::numeric_limits<double>::infinity();
  add_shapes(scene.spheres, scene, eye, threads, result);
  add_shapes(scene.capsules, scene, eye, threads, result);
  if (result.shapes() == 0) result.smallest_radius = result.nearest = 0;
  result.view_height = scene.camera.projection == Projection::orthographic
                           ? scene.camera.view_height
                           : 2 * scene.camera.tan_half_vfov * result.nearest;
  result.one_radius = result.shapes() > 0 && result.smallest_radius == result.largest_radius;
  return result;
}

ResolvedSettings resolve_settings(const Requirements& requirements, const RenderSettings& asked) {
  ResolvedSettings result{asked, "asked for", "asked for"};
  RenderSettings& settings = result.settings;
  if (settings.precision == Precision::automatic) decide_precision(requirements, result);
  if (settings.accelerator == AcceleratorKind::automatic) {
    const std::size_t most = largest_linear(settings.precision);
    const bool few = requirements.spheres <= most;
    settings.accelerator = few ? AcceleratorKind::linear : AcceleratorKind::bvh;
    result.accelerator_reason =
        std::to_string(requirements.spheres) +
        (few ? " spheres: auto uses a tree only above " : " spheres: auto uses a tree above ") +
        std::to_string(most);
  }
  if (settings.row_order == RowOrder::automatic) {
    settings.row_order = settings.schedule == SchedulePolicy::weighted ? RowOrder::interleaved
                                                                       : RowOrder::sequential;
  }
  return result;
}

}  // namespace parray::scene
