#pragma once

#include <cstdint>
#include <vector>

#include "common/scene/setting_choices.h"

namespace parray::schedule {

/// The input of a schedule policy, which decides the size of the next chunk: the work of one lease.
/// Work is counted in units, usually cells; a whole row has `row_units` units.
struct ChunkRequest {
  std::uint64_t total = 0;      ///< units of the whole job, > 0
  std::uint64_t remaining = 0;  ///< units not leased yet, 1 .. total
  std::uint64_t step = 0;       ///< chunks leased before this one
  std::uint64_t row_units = 1;  ///< units of one whole row, > 0
  std::uint32_t workers = 1;    ///< number of workers P, > 0
  std::uint32_t threads = 1;    ///< threads of the requesting worker, > 0
  double share = 1;             ///< speed of that worker divided by the speed of all, in (0, 1]
  /// Units of the smallest useful lease, > 0: a smaller one costs more time for messages than it
  /// saves by spreading the work.
  std::uint64_t least = 1;
  std::uint64_t most = UINT64_MAX;  ///< units that one lease should not exceed, >= least
};

/// Returns the units of the next chunk, 1 .. remaining. The function is pure: a simulator and an
/// MPI rank compute the same result as the coordinator.
///
/// - static_split: total / P units per worker, rounded up to whole rows.
/// - guided: ceil(R / P) rows of the R that remain, at least 2 rows per thread (Polychronopoulos
///   and Kuck, "Guided self-scheduling", 1987).
/// - factoring: batches of P equal chunks. Each batch takes half of the work that earlier batches
///   left; a chunk is rounded up to whole rows (Hummel, Schonberg, Flynn, "Factoring", 1992).
/// - weighted: `share` / 2 of the remaining work, not rounded to rows, between `least` and `most`
///   (Hummel, Schmidt, Uma, Wein, "Load-sharing in heterogeneous systems via weighted
///   factoring", 1996).
std::uint64_t chunk_units(SchedulePolicy policy, const ChunkRequest& request);

/// Returns the first unit of every chunk of a job, and then the total, for workers with the same
/// number of threads. Chunk `step` is [result[step], result[step + 1]). So a worker computes its
/// chunk from a step number alone. Ignores job.remaining and job.step. `policy` must not be
/// `weighted`, because its chunks depend on the requesting worker.
std::vector<std::uint64_t> chunk_starts(SchedulePolicy policy, ChunkRequest job);

}  // namespace parray::schedule
