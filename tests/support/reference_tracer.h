#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "common/scene/largest_radiance.h"
#include "common/scene/origin.h"
#include "common/scene/settings.h"
#include "common/trace/integrator/path.h"
#include "common/trace/integrator/scene_parts.h"
#include "common/trace/reference/scalar_tracer.h"
#include "tests/support/rooms.h"

/// The scalar reference of the lane kernels. It traces one path after the other, by linear search.
namespace parray::test {

struct ReferenceSums {
  std::vector<PixelSums> pixels;  ///< row after row
  TraceCounts counts;
  friend bool operator==(const ReferenceSums&, const ReferenceSums&) = default;
};

/// A scene with the data of one picture.
template <typename Real>
struct TracedPicture : TraceScene<Real>, PathEnds<Real> {};

/// Rounds spheres to `Store`, and computes everything else in `Real`.
template <typename Real, typename Store>
TracedPicture<Real> reference_scene(const Scene& scene, const RenderSettings& settings) {
  const Vec3d origin = scene_origin(scene);
  const Camera camera = moved(scene.camera, origin);
  TracedPicture<Real> result{
      {{}, {}, {}, stored_materials<Real>(scene), SkyGradient<Real>(scene.sky)},
      {CameraRays<Real>(camera, settings.width, settings.height), {}, settings.max_depth}};
  add_shapes<Store>(scene, origin, result);
  // Each path tests all shapes for its start.
  const std::optional<PixelBox> all({0, settings.width - 1, 0, settings.height - 1});
  result.start = StartShapes(RayStarts(camera, settings.width, settings.height),
                             result.shape_count(), [&](std::uint32_t) { return all; });
  return result;
}

template <typename Real, typename Store>
ReferenceSums reference_sums_in(const Scene& scene, const RenderSettings& settings) {
  const TracedPicture<Real> traced = reference_scene<Real, Store>(scene, settings);
  const Linear<Real> linear(traced.spheres);
  const RadianceScale scale(largest_radiance(scene));
  ReferenceSums result{std::vector<PixelSums>(std::size_t{settings.width} * settings.height), {}};
  InsideStack<Real> sides;
  for (std::uint32_t pixel = 0; pixel < result.pixels.size(); ++pixel) {
    for (std::uint32_t s = 0; s < settings.samples_per_pixel; ++s) {
      const SampleRandom random(settings.seed, pixel, s, settings.sampler);
      const Vec3<Real> value = trace_sample(traced, traced, linear, pixel % settings.width,
                                            pixel / settings.width, random, sides, result.counts);
      add_sample(vec_cast<double>(value), scale, s, result.pixels[pixel], result.counts);
    }
  }
  return result;
}

/// Returns the sums of all samples of a picture, in the settings' precision, which is not
/// `automatic`.
inline ReferenceSums reference_sums(const Scene& scene, const RenderSettings& settings) {
  switch (settings.precision) {
    case Precision::f64: return reference_sums_in<double, double>(scene, settings);
    case Precision::mixed: return reference_sums_in<double, float>(scene, settings);
    default: return reference_sums_in<float, float>(scene, settings);
  }
}

}  // namespace parray::test
