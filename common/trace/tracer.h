#pragma once

#include <memory>

#include "common/scene/settings_fwd.h"
#include "common/trace/integrator/path_tracer.h"

namespace parray::trace {

/// Builds the accelerator of a scene. Only `isa` may be `automatic`. The best instruction set of
/// the machine then replaces it, and likewise one that the machine lacks. The scene must have fewer
/// than 2^26 spheres. Time and memory are proportional to their number.
std::shared_ptr<const Accelerator> make_accelerator(const Scene& scene, Precision precision,
                                                    AcceleratorKind kind, Isa isa,
                                                    const BuildOptions& options = {});
/// The same for the values in the settings.
std::shared_ptr<const Accelerator> make_accelerator(const Scene& scene,
                                                    const RenderSettings& settings,
                                                    const BuildOptions& options = {});

/// Returns whether make_accelerator() would make an accelerator like `accelerator` from its scene
/// with these settings.
bool serves(const Accelerator& accelerator, const RenderSettings& settings);

/// Makes the tracer of the scene's own camera with its own accelerator. resolve_settings() must
/// have completed the settings.
std::unique_ptr<PathTracer> make_path_tracer(const Scene& scene, const RenderSettings& settings,
                                             const BuildOptions& options = {});

/// Does the same as make_path_tracer() with settings.picture().
std::unique_ptr<PathTracer> make_path_tracer(std::shared_ptr<const Accelerator> accelerator,
                                             const Camera& camera, const RenderSettings& settings);

/// Returns whether a tracer of a scene for one of the settings also serves the other.
bool same_tracer(const RenderSettings& a, const RenderSettings& b);

/// Makes the tracer that defines the same picture: path.h with linear search, independent of
/// settings.accelerator.
std::unique_ptr<PathTracer> make_scalar_tracer(const Scene& scene, const RenderSettings& settings);

}  // namespace parray::trace
