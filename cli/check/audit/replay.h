#pragma once

#include <cstdint>
#include <vector>

#include "common/scene/setting_choices.h"
#include "coordinator/jobs/journal.h"

namespace parray::audit {

/// How to replay a job. The replay uses the recorded costs of its cells and the coordinator's own
/// lease table and chunk sizer, in virtual time. Messages cost nothing: a worker usually has its
/// next lease already.
struct ReplayOptions {
  SchedulePolicy policy = SchedulePolicy::weighted;
  /// Number of copies of each recorded worker.
  std::uint32_t copies = 1;
};

struct Replayed {
  double seconds = 0;     ///< of all passes in sequence
  double efficiency = 0;  ///< work divided by time and threads, 0 to 1
  std::uint64_t leases = 0;
};

/// Throws RunError if the journal has no merged result, or results of a pass that never began.
Replayed replay_job(const std::vector<JournalEntry>& journal, const ReplayOptions& options);

/// A hypothetical worker.
struct ImaginedWorker {
  std::uint32_t threads = 1;
  double speed = 1;  ///< of each thread
};

/// Replays a pass of `grain` with at least one worker. All cells cost the same, in total
/// `thread_seconds` at speed 1.
Replayed replay_even_pass(const ChunkGrain& grain, double thread_seconds,
                          const std::vector<ImaginedWorker>& workers, SchedulePolicy policy);

}  // namespace parray::audit
