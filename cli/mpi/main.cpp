
#include "cli/mpi/mpi_options.h"
#include "cli/mpi/mpi_render.h"
#include "cli/mpi/mpi_world.h"
#include "common/process/run_main.h"
#include "common/process/stop_signal.h"

namespace {

constexpr const char* about = "Render a scene with all the ranks of one mpirun";

}  // namespace

/// All ranks read the same command line. Only rank 0 prints messages and returns a failure, because
/// mpirun ends all ranks, also rank 0, as soon as any rank fails.
int main(int argc, char** argv) {
  using namespace parray::mpi;
  const bool speaks = rank_in_environment() == 0;
  if (speaks) stop_at_signals();
  MpiOptions options;
  const Program program = {"parray-mpi", about, "parray-mpi " PARRAY_VERSION, speaks,
                           "mpirun -n P "};
  return run_main(program, argc, argv, [&](CommandLine& line) {
    options.add_to(line);
    return [&] { return mpi_render(options); };
  });
}
