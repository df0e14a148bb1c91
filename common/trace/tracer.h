#pragma once

#include <memory>
#include <span>
#include <vector>

#include "common/image/cell_records.h"
#include "common/scene/settings_fwd.h"
#include "common/trace/integrator/path_tracer.h"

namespace parray::trace {

/// Returns the instruction set of an accelerator on this machine. It is `asked`, or the best one if
/// `asked` is `automatic` or missing here. An octree always uses `scalar`.
Isa isa_for(AcceleratorKind kind, Isa asked);

/// Builds the accelerator of a scene, with the instruction set isa_for(kind, isa). Only `isa` may
/// be `automatic`. The scene has at most limits::max_shapes shapes. Memory is proportional to their
/// number, time nearly so. `threads` threads build, at least 1; the pictures have the same bits
/// with any number. Throws std::bad_alloc.
std::shared_ptr<const Accelerator> make_accelerator(const Scene& scene, Precision precision,
                                                    AcceleratorKind kind, Isa isa, int threads = 1);

/// Returns whether make_accelerator() with `settings` and the scene of `accelerator` would make an
/// accelerator with the same precision, kind and instruction set.
bool serves(const Accelerator& accelerator, const RenderSettings& settings);

/// Makes a tracer for the scene's camera and builds an accelerator for it. resolve_settings() must
/// have replaced every `automatic` in `settings`, except perhaps `isa`.
std::unique_ptr<PathTracer> make_path_tracer(const Scene& scene, const RenderSettings& settings,
                                             int threads = 1);

/// Returns whether all settings that make_path_tracer() reads are equal in `a` and `b`.
bool same_tracer(const RenderSettings& a, const RenderSettings& b);

/// Makes the tracer that defines the bits of the picture: it traces by path.h with linear search,
/// and ignores settings.accelerator and settings.isa.
std::unique_ptr<PathTracer> make_scalar_tracer(const Scene& scene, const RenderSettings& settings);

/// Returns the non-finite samples of a run of pixels, sorted, at most one entry per pixel. Traces
/// the run again, one pixel at a time. Call it for runs whose TraceCounts::nonfinite is not 0,
/// which a correct tracer never produces. `samples` has one range per pixel.
std::vector<ExcludedSamples> locate_nonfinite(const PathTracer& tracer, const PixelRun& run,
                                              std::span<const SampleRange> samples);

}  // namespace parray::trace
