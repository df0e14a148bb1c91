#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "coordinator/jobs/journal.h"

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

}  // namespace parray::audit
