#pragma once

#include <cstdint>
#include <vector>

#include "common/scene/settings.h"
#include "coordinator/jobs/journal.h"

namespace parray::audit {

/// A job as it could have been: the costs of its cells as they were recorded, dealt out by the
/// coordinator's own lease table and chunk sizer to other workers, or by another policy, in virtual
/// time. Messages cost nothing, as they do while a worker has a lease at hand.
struct ReplayOptions {
  SchedulePolicy policy = SchedulePolicy::weighted;
  /// How often each of the recorded workers is there.
  std::uint32_t copies = 1;
};

struct Replayed {
  double seconds = 0;     ///< of all passes, one after the other
  double efficiency = 0;  ///< work over time and threads, 0 .. 1
  std::uint64_t leases = 0;
};

/// Throws RunError when the journal has no complete pass.
Replayed replay_job(const std::vector<JournalEntry>& journal, const ReplayOptions& options);

/// A worker that there might be.
struct ImaginedWorker {
  std::uint32_t threads = 1;
  double speed = 1;  ///< of each thread
};

/// A pass of `grain` whose cells cost the same each, `thread_seconds` together at speed 1, dealt
/// out likewise to `workers`, at least one.
Replayed replay_even_pass(const ChunkGrain& grain, double thread_seconds,
                          const std::vector<ImaginedWorker>& workers, SchedulePolicy policy);

}  // namespace parray::audit
