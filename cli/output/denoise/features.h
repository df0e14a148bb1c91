#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

#include "cli/output/denoise/plane.h"
#include "common/scene/scene.h"
#include "common/scene/settings.h"
#include "common/trace/integrator/path_tracer.h"

namespace parray::denoise {

/// What the camera rays of a pixel meet, in the mean: albedo (R, G, B), normal (x, y, z, on the
/// side that the ray comes from), and one over the depth, scaled so that it varies by about 1 over
/// the picture. Of the sky the normal is the way back along the ray, in which its radiance is
/// linear, and all else is 0.
inline constexpr std::size_t feature_count = 7;
using FeaturePlanes = std::vector<Plane>;  ///< feature_count of them

/// The features of a picture: as the samples of either half have them, and as they are.
struct Features {
  /// By the first samples of the even and of the odd half: their noise is that of the half's
  /// radiance, so that what depends on features can be told from it.
  std::array<FeaturePlanes, 2> own;
  /// By many other samples, which no half has.
  FeaturePlanes steady;
  /// By image row, whether all of these have met nothing but sky, which has no noise to speak of.
  /// Empty: nowhere.
  std::vector<char> plain_sky;
};

/// Samples of a pixel, both halves together, whose features are traced.
inline constexpr std::uint32_t own_feature_samples = 16;
/// Other samples for the steady features: few where they and those of the pixels around all meet
/// the same sphere, else many.
inline constexpr std::uint32_t few_steady_samples = 8;
inline constexpr std::uint32_t many_steady_samples = 64;

/// Traces them by the accelerator that `tracer` has; `tracer` was made for `scene` and `settings`,
/// and each pixel of the picture has at least `samples`, which is 2 or more. The same values for
/// any number of threads. `between_bands`, if set, is called several times a second; what it throws
/// ends the work.
Features trace_features(const PathTracer& tracer, const Scene& scene,
                        const RenderSettings& settings, std::uint32_t samples, int threads,
                        const std::function<void()>& between_bands = {});

/// The same, where `steady` traces the steady features: steady_tracer(), or a part of it.
Features trace_features(const PathTracer& tracer, const PathTracer& steady, const Scene& scene,
                        const RenderSettings& settings, std::uint32_t samples, int threads,
                        const std::function<void()>& between_bands = {});

/// Traces samples that the picture of `tracer` does not have.
std::unique_ptr<PathTracer> steady_tracer(const PathTracer& tracer, const Scene& scene,
                                          const RenderSettings& settings);

}  // namespace parray::denoise
