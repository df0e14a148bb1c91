#pragma once

#include <memory>

#include "common/trace/integrator/path_tracer.h"

namespace parray::trace {

/// Builds the accelerator of a scene; nothing is `automatic` but perhaps `isa`: an instruction set
/// that the machine lacks, too, is replaced by its best. Fewer than 2^26 spheres; time and memory
/// are in proportion to them.
std::shared_ptr<const Accelerator> make_accelerator(const Scene& scene, Precision precision,
                                                    AcceleratorKind kind, Isa isa,
                                                    const BuildOptions& options = {});

/// Whether `accelerator` is what make_accelerator() would make of its scene by these settings.
bool serves(const Accelerator& accelerator, const RenderSettings& settings);

/// The tracer of the scene's own camera, and an accelerator for it alone, by settings that
/// resolve_settings() has completed.
std::unique_ptr<PathTracer> make_path_tracer(const Scene& scene, const RenderSettings& settings,
                                             const BuildOptions& options = {});

/// The definition of the same picture: path.h by linear search, whatever settings.accelerator says.
std::unique_ptr<PathTracer> make_scalar_tracer(const Scene& scene, const RenderSettings& settings);

}  // namespace parray::trace
