#pragma once

#include <memory>

#include "common/trace/integrator/path_tracer.h"

namespace parray::trace {

/// Makes an accelerator, linear search or the tree, with tracers that are the kernels of an
/// instruction set. This machine must have the instruction set. The scene must have fewer than 2^26
/// spheres; memory is proportional to their number.
std::shared_ptr<const Accelerator> make_wavefront_accelerator(const Scene& scene,
                                                              Precision precision,
                                                              AcceleratorKind kind, Isa isa,
                                                              const BuildOptions& options);

/// Does the same as make_path_tracer(), but with kernels for every feature that a scene could have:
/// other code, the same bits. For tests and benchmarks.
std::unique_ptr<PathTracer> make_general_path_tracer(std::shared_ptr<const Accelerator> accelerator,
                                                     const Camera& camera,
                                                     const PictureSettings& picture);

}  // namespace parray::trace
