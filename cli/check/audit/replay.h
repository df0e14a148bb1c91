#pragma once

#include <cstdint>
#include <vector>

#include "common/scene/setting_choices.h"
#include "coordinator/jobs/journal.h"

namespace parray::audit {

/// How to replay a job. The replay uses the recorded tracing times of its cells and the
/// coordinator's own lease table and chunk sizer, in virtual time. Messages take no time, because a
/// worker usually has its next lease already.
struct ReplayOptions {
  SchedulePolicy policy = SchedulePolicy::weighted;
  /// Number of simulated workers for each recorded worker that has merged results; 1: as recorded.
  /// At least 1.
  std::uint32_t copies = 1;
};

struct Replayed {
  double seconds = 0;        ///< virtual time of all passes in sequence
  double efficiency = 0;     ///< share of all thread-seconds that trace merged results, 0 to 1
  std::uint64_t leases = 0;  ///< granted, including copies of leases that were not finished
};

/// Replays all passes of the journal. Cells without a merged result take no time. Throws RunError
/// if the journal has no merged result, or results of a pass that never began.
Replayed replay_job(const std::vector<JournalEntry>& journal, const ReplayOptions& options);

/// A hypothetical worker.
struct ImaginedWorker {
  std::uint32_t threads = 1;
  double speed = 1;  ///< of each thread, relative to a thread of speed 1
};

/// Replays one pass of `grain.cells` cells. Needs at least one worker. All cells take the same
/// time: together `thread_seconds` on one thread of speed 1.
Replayed replay_even_pass(const ChunkGrain& grain, double thread_seconds,
                          const std::vector<ImaginedWorker>& workers, SchedulePolicy policy);

}  // namespace parray::audit
