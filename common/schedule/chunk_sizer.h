#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "common/schedule/chunk_policy.h"
#include "common/schedule/work_plan.h"

namespace parray::schedule {

/// Speeds of all workers of a job together, as far as they are measured.
struct FarmSpeed {
  double samples_per_second = 0;       ///< of those that are measured, together
  std::uint64_t measured_threads = 0;  ///< their threads
  std::uint64_t threads = 1;           ///< of all workers
  std::uint32_t workers = 1;
};

/// Who asks for a lease.
struct LeaseRequest {
  std::uint32_t threads = 1;
  double samples_per_second = 0;  ///< as measured; 0: not yet
};

struct LeaseLength {
  /// Weighted leases are between these two long, by measured speed, in seconds: shorter costs
  /// messages, longer costs more when a worker is lost, and makes progress jerk.
  double shortest = 0.002;
  double longest = 1;
};

/// What a chunk's size depends on of a plan.
struct ChunkGrain {
  std::uint64_t cells = 0;
  std::uint64_t row_cells = 1;    ///< of one whole row
  std::uint32_t piece_cells = 1;  ///< that a thread takes at a time
  double cell_samples = 1;        ///< on average; > 0
};
ChunkGrain grain_of(const WorkPlan& plan);

/// How many cells the next lease has, whichever way leases are handed out. Immutable.
class ChunkSizer {
 public:
  /// Of a plan's cells, or of `cells` of them.
  ChunkSizer(SchedulePolicy policy, const WorkPlan& plan, LeaseLength length,
             std::optional<std::uint64_t> cells = {});
  /// Of any plan of that grain.
  ChunkSizer(SchedulePolicy policy, const ChunkGrain& grain, LeaseLength length);

  /// Of `remaining` > 0 cells; `step` chunks have been handed out before. 1 .. remaining.
  [[nodiscard]] std::uint64_t cells(const LeaseRequest& request, const FarmSpeed& farm,
                                    std::uint64_t remaining, std::uint64_t step) const;

  /// Where every chunk begins, and the number of cells at the end, when all askers are alike; not
  /// for `weighted`. See chunk_starts().
  [[nodiscard]] std::vector<std::uint64_t> starts(std::uint32_t workers,
                                                  std::uint32_t threads_each) const;

 private:
  SchedulePolicy policy_;
  LeaseLength length_;
  ChunkGrain grain_;
};

}  // namespace parray::schedule
