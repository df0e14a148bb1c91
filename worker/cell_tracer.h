#pragma once

#include <atomic>
#include <cstdint>

#include "common/schedule/cell_grid.h"
#include "common/schedule/traced_cells.h"
#include "common/trace/integrator/path_tracer.h"

namespace parray::worker {

/// Traces cells with `threads` OpenMP threads. Each thread takes a piece of
/// batch.grid->shape().piece_cells cells at a time.
///
/// `traced` grows by the samples of each finished cell. `stop` ends the work within the time of one
/// cell; the result is then incomplete. If a thread throws, the other threads stop, and the
/// function rethrows the exception.
///
/// After `longest` seconds (0: no limit) no thread begins another piece. The result then contains
/// only the first cells of the range, at least one piece.
TracedCells trace_cells(const PathTracer& tracer, const CellBatch& batch, int threads,
                        std::atomic<std::uint64_t>& traced, const std::atomic<bool>& stop,
                        double longest = 0);

}  // namespace parray::worker
