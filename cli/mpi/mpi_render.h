#pragma once

#include "cli/mpi/mpi_options.h"

namespace parray::mpi {

/// Renders a scene with all ranks of this mpirun. Rank 0 returns the exit status, other ranks
/// return 0. Throws as an Action of `parray` does. An error during the work ends all ranks
/// (MPI_Abort).
int mpi_render(const MpiOptions& options);

}  // namespace parray::mpi
