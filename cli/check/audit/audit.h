#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "common/scene/setting_choices.h"
#include "coordinator/jobs/journal.h"

/// Reads a job's journal. Audits check that every cell counts once, and sum up where the time was
/// spent. Replays predict how long the job would take with other schedules.
namespace parray::audit {

/// Result of checking a job's journal.
struct Audit {
  struct Worker {
    std::string name;
    std::uint32_t threads = 0;
    std::uint64_t leases = 0;  ///< merged, without problems
    std::uint64_t cells = 0;   ///< of these leases, including cells that were later set back
    double seconds = 0;        ///< tracing time of these leases, as the worker reported it
  };
  /// Entries that audit_journal() does not accept: one line each, the first hundred.
  std::vector<std::string> problems;
  std::uint64_t cells = 0;   ///< of all begun passes
  std::uint64_t merged = 0;  ///< merged cells, without those that were set back
  /// Cells whose merged results were removed: all cells of the pixels of which a faulty machine had
  /// traced a cell, including cells that other machines traced.
  std::uint64_t set_back = 0;
  std::uint64_t leases = 0;  ///< all merges, including those that are problems
  std::uint64_t passes = 0;
  std::vector<Worker> workers;  ///< in the order of the journal

  /// Returns whether there is no problem and every cell of every begun pass is merged.
  [[nodiscard]] bool complete() const { return problems.empty() && merged == cells; }
};

/// Checks that every cell counts once. Follows the journal from its beginning. Each merge must have
/// unmerged cells of a begun pass, a lease without an earlier merge, and a worker that an earlier
/// entry describes. Cells that are set back must be merged. A pass begins only once.
Audit audit_journal(const std::vector<JournalEntry>& journal);

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

struct Replayed {
  double seconds = 0;        ///< virtual time of all passes in sequence
  double efficiency = 0;     ///< share of all thread-seconds that trace merged results, 0 to 1
  std::uint64_t leases = 0;  ///< granted, including copies of leases that were not finished
};

/// Replays all passes of the journal, with the recorded tracing times of its cells and the
/// coordinator's own lease table and chunk sizer, in virtual time. Messages take no time, because a
/// worker usually has its next lease already. Cells without a merged result take no time. `copies`:
/// number of simulated workers for each recorded worker that has merged results, at least 1. Throws
/// RunError if the journal has no merged result, or results of a pass that never began.
Replayed replay_job(const std::vector<JournalEntry>& journal, SchedulePolicy policy,
                    std::uint32_t copies);

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
