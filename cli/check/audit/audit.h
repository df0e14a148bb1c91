#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "coordinator/jobs/journal.h"

namespace parray::audit {

/// What a job's journal proves.
struct Audit {
  struct Worker {
    std::string name;
    std::uint32_t threads = 0;
    std::uint64_t leases = 0;
    std::uint64_t cells = 0;  ///< merged, those that were set back included
    double seconds = 0;       ///< spent tracing
  };
  /// What contradicts "no cell counts twice": one line each, the first hundred.
  std::vector<std::string> problems;
  std::uint64_t cells = 0;     ///< of all passes that have begun
  std::uint64_t merged = 0;    ///< of these
  std::uint64_t set_back = 0;  ///< cells whose results were found wrong
  std::uint64_t leases = 0;
  std::uint64_t passes = 0;
  std::vector<Worker> workers;

  [[nodiscard]] bool complete() const { return problems.empty() && merged == cells; }
};

/// Follows the journal from its beginning: each merge must be of cells that a pass has and that are
/// not merged, under a lease that has not been merged, by a worker that is named.
Audit audit_journal(const std::vector<JournalEntry>& journal);

}  // namespace parray::audit
