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
    std::uint64_t leases = 0;
    std::uint64_t cells = 0;  ///< merged, including cells that were set back
    double seconds = 0;       ///< spent tracing
  };
  /// Violations of "no cell counts twice": one line each, at most a hundred.
  std::vector<std::string> problems;
  std::uint64_t cells = 0;     ///< of all begun passes
  std::uint64_t merged = 0;    ///< merged cells, without those that were set back
  std::uint64_t set_back = 0;  ///< cells with wrong results
  std::uint64_t leases = 0;
  std::uint64_t passes = 0;
  std::vector<Worker> workers;

  [[nodiscard]] bool complete() const { return problems.empty() && merged == cells; }
};

/// Follows the journal from its beginning. Each merge must have unmerged cells of a begun pass, a
/// new lease and a known worker. Cells that are set back must be merged. A pass begins only once.
Audit audit_journal(const std::vector<JournalEntry>& journal);

}  // namespace parray::audit
