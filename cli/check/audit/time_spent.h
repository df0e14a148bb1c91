#pragma once

#include <vector>

#include "coordinator/jobs/journal.h"

namespace parray::audit {

/// Distribution of a job's time, from its journal. The last four members are shares, 0 to 1, of all
/// thread-seconds between each worker's first lease and the job's last result.
struct TimeSpent {
  double seconds = 0;         ///< from the first lease to the last result
  std::uint32_t threads = 0;  ///< of all workers together
  std::size_t workers = 0;    ///< workers with merged results
  double tracing = 0;         ///< tracing merged results
  double start = 0;           ///< first lease of each worker, minus its tracing: fetching the scene
  double between = 0;         ///< the rest: messages, waiting, tracing of results not merged
  double tail = 0;            ///< after a worker's last result
};

/// Returns the distribution. Leases without merged results do not count. All values are 0 if
/// nothing was merged.
TimeSpent time_spent(const std::vector<JournalEntry>& journal);

}  // namespace parray::audit
