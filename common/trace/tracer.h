#pragma once

#include <memory>

#include "common/scene/settings_fwd.h"
#include "common/trace/integrator/path_tracer.h"

namespace parray::trace {

/// Returns the instruction set of an accelerator on this machine. It is `asked`, or the best one if
/// `asked` is `automatic` or missing here. An octree always uses `scalar`.
Isa isa_for(AcceleratorKind kind, Isa asked);

/// Builds the accelerator of a scene, with the instruction set isa_for(kind, isa). Only `isa` may
/// be `automatic`. The scene has at most limits::max_shapes shapes. Memory is proportional to their
/// number, time nearly so. Throws std::bad_alloc.
std::shared_ptr<const Accelerator> make_accelerator(const Scene& scene, Precision precision,
                                                    AcceleratorKind kind, Isa isa,
                                                    const BuildOptions& options = {});
/// Does the same with the precision, accelerator and instruction set of `settings`.
std::shared_ptr<const Accelerator> make_accelerator(const Scene& scene,
                                                    const RenderSettings& settings,
                                                    const BuildOptions& options = {});

/// Returns whether make_accelerator() with `settings` and the scene of `accelerator` would make an
/// accelerator with the same precision, kind and instruction set.
bool serves(const Accelerator& accelerator, const RenderSettings& settings);

/// Makes a tracer for the scene's camera and builds an accelerator for it. resolve_settings() must
/// have replaced every `automatic` in `settings`, except perhaps `isa`.
std::unique_ptr<PathTracer> make_path_tracer(const Scene& scene, const RenderSettings& settings,
                                             const BuildOptions& options = {});

/// Does the same as make_path_tracer() of path_tracer.h with settings.picture().
std::unique_ptr<PathTracer> make_path_tracer(std::shared_ptr<const Accelerator> accelerator,
                                             const Camera& camera, const RenderSettings& settings);

/// Returns whether all settings that make_path_tracer() reads are equal in `a` and `b`.
bool same_tracer(const RenderSettings& a, const RenderSettings& b);

/// Makes the tracer that defines the bits of the picture: it traces by path.h with linear search,
/// and ignores settings.accelerator and settings.isa.
std::unique_ptr<PathTracer> make_scalar_tracer(const Scene& scene, const RenderSettings& settings);

}  // namespace parray::trace
