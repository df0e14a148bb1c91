#pragma once

#include <vector>

#include "coordinator/jobs/journal.h"

namespace parray::audit {

/// Distribution of a job's time, from its journal: shares of the thread-seconds between each
/// worker's first lease and the job's last result.
struct TimeSpent {
  double seconds = 0;  ///< from the first grant to the last result
  std::uint32_t threads = 0;
  std::size_t workers = 0;
  double tracing = 0;
  double start = 0;    ///< before a worker had the scene and its accelerator
  double between = 0;  ///< messages, waiting for the next lease or pass, copies that lost
  double tail = 0;     ///< after a worker's last result
};

/// All values are 0 if nothing was merged.
TimeSpent time_spent(const std::vector<JournalEntry>& journal);

}  // namespace parray::audit
