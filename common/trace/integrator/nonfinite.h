#pragma once

#include <span>
#include <vector>

#include "common/image/cell_records.h"
#include "common/trace/integrator/path_tracer.h"

namespace parray::trace {

/// Returns the non-finite samples of a run of pixels, sorted, at most one entry per pixel. Traces
/// the run again, one pixel at a time. Call it for runs whose TraceCounts::nonfinite is not 0,
/// which a correct tracer never produces. `samples` has one range per pixel.
std::vector<ExcludedSamples> locate_nonfinite(const PathTracer& tracer, const PixelRun& run,
                                              std::span<const SampleRange> samples);

}  // namespace parray::trace
