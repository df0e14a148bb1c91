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

/// Number of samples per pixel for extra channels; settings.samples_per_pixel if that is less.
inline constexpr std::uint32_t channel_samples = 16;

/// Traces the extra channels `wanted` of the picture that `tracer` makes from `scene` with
/// `settings`. Uses the camera rays and paths of the picture's own samples 0 .. channel_samples -
/// 1, in the picture's precision. Means are over these samples.
///
/// - depth, "Z": mean distance from the camera's plane along the direction of view, in the scene's
///   unit, over the samples that meet a shape. Infinite if no sample does.
/// - normal, "N.X", "N.Y", "N.Z": mean of the unit normals of the first surfaces, in the scene's
///   axes. Each normal points to the side from which the ray comes. The sky counts as 0, so the
///   mean is shorter than 1 at edges.
/// - albedo, "albedo.R", "albedo.G", "albedo.B": mean albedo of the first surfaces; 1 for glass, 0
///   for the sky.
/// - sphere, "sphere": number (from 0) of the shape that sample 0 meets first, spheres before
///   capsules (see Scene); 2^32 - 1 for the sky. Whole numbers; all other channels are floats.
/// - cost, "cost": mean number of ray segments of a sample's path.
///
/// Normal and albedo have the form that denoisers expect (Intel Open Image Denoise, documentation
/// of filter RT). The values are the same for any number of `threads`, accelerator and instruction
/// set. Calls `between_bands`, if set, in the calling thread before each band of rows with about
/// 2^18 samples (at least one row). An exception of it ends the work.
Channels trace_channels(const PathTracer& tracer, const Scene& scene,
                        const RenderSettings& settings, const Aovs& wanted, int threads,
                        const std::function<void()>& between_bands = {});

/// Traces the same channels for some pixels only. Each run in `pixels` must have exactly one pixel.
/// The values of each channel are in the order of the runs.
Channels trace_channels(const PathTracer& tracer, const Scene& scene,
                        const RenderSettings& settings, const Aovs& wanted,
                        std::span<const PixelRun> pixels, int threads);

/// Returns, for each pixel in image order, the samples whose camera rays hit the background: their
/// number and the sum of their radiance. Traces only camera rays. `samples` is the number of
/// samples of each pixel in image order. The result is the same for any number of `threads`,
/// accelerator and instruction set. For `between_bands` see above.
std::vector<SkySamples> trace_sky_samples(const PathTracer& tracer, const RenderSettings& settings,
                                          std::span<const std::uint32_t> samples, int threads,
                                          const std::function<void()>& between_bands = {});

}  // namespace parray::output
