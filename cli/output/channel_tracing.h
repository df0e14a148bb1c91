#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "cli/output/picture/channels.h"
#include "common/scene/scene.h"
#include "common/scene/settings_fwd.h"
#include "common/trace/integrator/path_tracer.h"

namespace parray::output {

/// Number of samples of each pixel that extra channels are traced with; fewer if the pixel has
/// fewer.
inline constexpr std::uint32_t channel_samples = 16;

/// Traces the extra channels `wanted` of the picture that `tracer` makes of `scene` by `settings`.
/// Camera rays and paths are those of the picture's own samples 0 .. channel_samples - 1, in its
/// precision. Means are over these samples.
///
/// - depth, "Z": mean distance from the camera's plane, along the direction in which it looks, in
///   the scene's unit; over the samples that meet a sphere. Infinite where none does.
/// - normal, "N.X", "N.Y", "N.Z": mean of the unit normals of the first surfaces, in the scene's
///   axes, each on the side that the ray comes from. The sky counts as 0, so that the mean is
///   shorter than 1 at edges.
/// - albedo, "albedo.R", "albedo.G", "albedo.B": mean albedo of the first surfaces; 1 for glass, 0
///   for the sky.
/// - sphere, "sphere": place (from 0) in Scene::spheres of the sphere that sample 0 meets first;
///   2^32 - 1 for the sky. Whole numbers; all others are floats.
/// - cost, "cost": mean number of ray segments of a sample's path.
///
/// Normal and albedo are what denoisers expect (Intel Open Image Denoise, documentation of filter
/// RT). The same values for any number of `threads`, accelerator and instruction set.
/// `between_bands`, if set, is called several times a second; what it throws ends the work.
Channels trace_channels(const PathTracer& tracer, const Scene& scene,
                        const RenderSettings& settings, const Aovs& wanted, int threads,
                        const std::function<void()>& between_bands = {});

/// Does the same for single pixels: each run has one pixel, and the values are in the order of the
/// runs.
Channels trace_channels(const PathTracer& tracer, const Scene& scene,
                        const RenderSettings& settings, const Aovs& wanted,
                        std::span<const PixelRun> pixels, int threads);

/// Counts the samples of each pixel that hit the background. Traces only camera rays. `samples`:
/// number of samples of each pixel in image order; empty: settings.samples_per_pixel. The result is
/// the same for any number of `threads`, accelerator and instruction set; `between_bands` as above.
std::vector<SkySamples> trace_sky_samples(const PathTracer& tracer, const RenderSettings& settings,
                                          std::span<const std::uint32_t> samples, int threads,
                                          const std::function<void()>& between_bands = {});

}  // namespace parray::output
