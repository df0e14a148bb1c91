#pragma once

#include <vector>

#include "coordinator/jobs/journal.h"

namespace parray::audit {

/// Where a job's time went, from its journal. Shares of the thread-seconds that its workers had
/// from their first lease to the job's last result.
struct TimeSpent {
  double seconds = 0;  ///< from the first grant to the last result
  std::uint32_t threads = 0;
  std::size_t workers = 0;
  double tracing = 0;
  double start = 0;    ///< until a worker had the scene and its accelerator
  double between = 0;  ///< messages, waiting for the next lease or pass, copies that came second
  double tail = 0;     ///< after a worker's last result
};

/// All zero where nothing has been merged.
TimeSpent time_spent(const std::vector<JournalEntry>& journal);

}  // namespace parray::audit
