#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "common/image/row_block.h"
#include "common/trace/kernel.h"

namespace parray {

/// Which samples of a piece of work were not finite, by tracing the piece again, a pixel at a time:
/// for pieces whose counts say that there are some, which no correct kernel's ever do. `samples`
/// has a range for each pixel; `position` is that of the run's row in the row order.
std::vector<ExcludedSamples> locate_nonfinite(const Kernel& kernel, const PixelRun& run,
                                              std::span<const SampleRange> samples,
                                              std::uint32_t position);

}  // namespace parray
