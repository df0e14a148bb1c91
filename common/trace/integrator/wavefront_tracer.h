#pragma once

#include <memory>

#include "common/trace/integrator/path_tracer.h"

namespace parray::trace {

/// Makes an accelerator of the kind `linear` or `bvh`. Its tracers run the kernels that are
/// compiled for the instruction set `isa`. No argument may be `automatic`. The caller must know
/// that this machine can run `isa`: the function does not check it. The scene has at most
/// limits::max_shapes shapes; memory is proportional to their number. `threads` threads build, at
/// least 1. Throws std::bad_alloc.
std::shared_ptr<const Accelerator> make_wavefront_accelerator(const Scene& scene,
                                                              Precision precision,
                                                              AcceleratorKind kind, Isa isa,
                                                              int threads);

}  // namespace parray::trace
