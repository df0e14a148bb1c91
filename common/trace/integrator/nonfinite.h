#pragma once

#include <span>
#include <vector>

#include "common/image/cell_records.h"
#include "common/trace/integrator/path_tracer.h"

namespace parray::trace {

/// Which samples of a run of pixels were not finite, by tracing it again, a pixel at a time: for
/// runs whose counts say that there are some, which no correct tracer's ever do. `samples` has a
/// range for each pixel. Sorted.
std::vector<ExcludedSamples> locate_nonfinite(const PathTracer& tracer, const PixelRun& run,
                                              std::span<const SampleRange> samples);

}  // namespace parray::trace
