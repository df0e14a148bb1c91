#pragma once

#include <memory>

#include "common/trace/integrator/path_tracer.h"

namespace parray::trace {

/// The accelerator whose tracers are the kernels of an instruction set, which this machine has:
/// linear search or the tree. Fewer than 2^26 spheres; memory is in proportion to them.
std::shared_ptr<const Accelerator> make_wavefront_accelerator(const Scene& scene,
                                                              Precision precision,
                                                              AcceleratorKind kind, Isa isa,
                                                              const BuildOptions& options);

/// make_path_tracer(), but ready for all that a scene could contain: the same bits by other code.
/// For tests and benchmarks.
std::unique_ptr<PathTracer> make_general_path_tracer(std::shared_ptr<const Accelerator> accelerator,
                                                     const Camera& camera,
                                                     const PictureSettings& picture);

}  // namespace parray::trace
