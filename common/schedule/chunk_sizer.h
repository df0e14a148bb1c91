#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "common/schedule/work_plan.h"

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

/// The combined speed of all workers of a job, as far as it has been measured. A worker that has
/// not been measured counts as fast per thread as the measured ones.
struct FarmSpeed {
  double samples_per_second = 0;       ///< total of the measured workers
  std::uint64_t measured_threads = 0;  ///< threads of the measured workers
  std::uint64_t threads = 1;           ///< threads of all workers
  std::uint32_t workers = 1;
};

/// The worker that requests a lease.
struct LeaseRequest {
  std::uint32_t threads = 1;
  double samples_per_second = 0;  ///< measured speed; 0: not measured yet
};

/// Bounds for the size of weighted leases.
struct LeaseLength {
  /// Bounds for the time that a lease takes at its worker's measured speed, in seconds. A shorter
  /// lease costs more time for messages than it saves by spreading the work. A longer lease loses
  /// more work if its worker disappears, and makes progress uneven. A worker without a measured
  /// speed gets at most 100 000 samples per thread instead, about 10 ms. A lease has at least
  /// ChunkGrain::piece_cells cells per thread, even if it then takes longer than `longest`.
  double shortest = 0.002;
  double longest = 1;
};

/// The properties of a plan that determine the size of a chunk.
struct ChunkGrain {
  std::uint64_t cells = 0;
  std::uint64_t row_cells = 1;    ///< cells of one whole row
  std::uint32_t piece_cells = 1;  ///< cells that a thread takes at a time
  double cell_samples = 1;        ///< average samples of a cell, > 0
};
ChunkGrain grain_of(const WorkPlan& plan);

/// Computes the number of cells of the next lease, for every transport. Immutable.
class ChunkSizer {
 public:
  /// Sizes leases of all cells of a plan, or of only `cells` of them, such as those that a restart
  /// left.
  ChunkSizer(SchedulePolicy policy, const WorkPlan& plan, LeaseLength length,
             std::optional<std::uint64_t> cells = {});
  /// Sizes leases of any plan with this grain.
  ChunkSizer(SchedulePolicy policy, const ChunkGrain& grain, LeaseLength length);

  /// Returns the number of cells of the next lease, 1 .. remaining. `remaining` must be > 0; `step`
  /// chunks have been leased before.
  [[nodiscard]] std::uint64_t cells(const LeaseRequest& request, const FarmSpeed& farm,
                                    std::uint64_t remaining, std::uint64_t step) const;

  /// Returns the first cell of every chunk, and the number of cells at the end, for `workers` with
  /// `threads_each` threads each. The policy must not be `weighted`. See chunk_starts().
  [[nodiscard]] std::vector<std::uint64_t> starts(std::uint32_t workers,
                                                  std::uint32_t threads_each) const;

 private:
  SchedulePolicy policy_;
  LeaseLength length_;
  ChunkGrain grain_;
};

}  // namespace parray::schedule
