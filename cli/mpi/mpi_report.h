#pragma once

#include <nlohmann/json.hpp>

#include "cli/mpi/mpi_coordinator.h"

namespace parray::mpi {

/// What an MPI job's report has beyond any job's: the map "mpi" of cli/REFERENCE.md, "The report".
nlohmann::json mpi_report(const MpiCoordinator& coordinator, const Ranks& ranks, MpiMode mode,
                          const char* transport, double render_seconds, bool row_seconds);

}  // namespace parray::mpi
