#pragma once

#include <atomic>
#include <cstdint>

#include "common/schedule/cell_grid.h"
#include "common/schedule/traced_cells.h"
#include "common/trace/integrator/path_tracer.h"

namespace parray::worker {

/// Traces cells with `threads` OpenMP threads, which take shape().piece_cells of them at a time.
///
/// `traced` grows by the samples of each cell as it is done. `stop` ends the work within a cell's
/// time; the result is then incomplete. What a thread throws stops the others, and is thrown here.
///
/// After `longest` seconds (0: never) no thread begins another piece. The result then has the
/// range's first cells alone, at least one piece of them.
TracedCells trace_cells(const PathTracer& tracer, const CellBatch& batch, int threads,
                        std::atomic<std::uint64_t>& traced, const std::atomic<bool>& stop,
                        double longest = 0);

}  // namespace parray::worker
