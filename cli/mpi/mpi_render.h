#pragma once

#include "cli/mpi/mpi_options.h"

namespace parray::mpi {

/// parray-mpi, once the command line is understood: renders a scene with all ranks of this mpirun.
/// Rank 0 returns the exit status, the others 0. Throws as an Action of `parray` does; errors in
/// the middle of the work end all ranks (MPI_Abort).
int mpi_render(const MpiOptions& options);

}  // namespace parray::mpi
