#pragma once

#include <memory>

#include "common/trace/integrator/path_tracer.h"

namespace parray::trace {

/// Makes an accelerator of the kind `linear` or `bvh`. Its tracers run the kernels that are
/// compiled for the instruction set `isa`. No argument may be `automatic`. The caller must know
/// that this machine can run `isa`: the function does not check it. The scene has at most
/// limits::max_shapes shapes; memory is proportional to their number. Throws std::bad_alloc.
std::shared_ptr<const Accelerator> make_wavefront_accelerator(const Scene& scene,
                                                              Precision precision,
                                                              AcceleratorKind kind, Isa isa,
                                                              const BuildOptions& options);

/// Makes a tracer like make_path_tracer(). Its kernels contain the code of every feature
/// (KernelFeatures), even if the scene lacks the feature. The bits of its pictures are the same.
/// For tests and benchmarks.
std::unique_ptr<PathTracer> make_general_path_tracer(std::shared_ptr<const Accelerator> accelerator,
                                                     const Camera& camera,
                                                     const PictureSettings& picture);

}  // namespace parray::trace
