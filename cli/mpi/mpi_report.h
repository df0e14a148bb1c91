#pragma once

#include <nlohmann/json.hpp>
#include <vector>

#include "cli/mpi/mpi_job.h"
#include "coordinator/job.h"
#include "coordinator/window_ledger.h"

namespace parray {

/// What an MPI job's report has beyond any job's: the map "mpi" of README.md, "The report".
nlohmann::json mpi_report(const Job& job, const Transport& transport, MpiMode mode,
                          const std::vector<RankFacts>& ranks, const WindowLayout& layout,
                          WindowLedger& ledger, double render_seconds, bool row_seconds);

/// Puts what the ranks have told into the job, for make_report().
void note_ranks(Job& job, const std::vector<RankFacts>& ranks, const WindowLayout& layout,
                WindowLedger& ledger);

}  // namespace parray
