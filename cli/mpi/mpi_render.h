#pragma once

#include "cli/mpi/mpi_options.h"

namespace parray::mpi {

/// Renders a scene with all ranks of this mpirun. Rank 0 returns the exit status, other ranks
/// return 0. Throws InputError, RunError or Interrupted before the ranks begin to render. An error
/// during rendering prints a line on stderr and ends all ranks. If rank 0 cannot write the files,
/// it prints a line on stderr and returns the exit status.
int mpi_render(const MpiOptions& options);

}  // namespace parray::mpi
