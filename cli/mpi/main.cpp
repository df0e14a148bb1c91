#include <CLI/CLI.hpp>
#include <iostream>

#include "cli/front_door.h"
#include "cli/interrupt.h"
#include "cli/mpi/mpi_options.h"
#include "cli/mpi/mpi_render.h"
#include "cli/mpi/mpi_world.h"
#include "cli/usage_error.h"

namespace {

constexpr const char* program = "parray-mpi";
constexpr const char* about =
    "Renders a scene with all the ranks of one mpirun:\n  mpirun -n P parray-mpi SCENE -o IMAGE";
constexpr const char* footer =
    "\nAs root mpirun wants --allow-run-as-root, and for more ranks than cores --oversubscribe.\n"
    "Exit status: 0 done; 1 failed; 2 bad usage or bad input; 130 interrupted.";

/// All ranks read the same command line; one speaks, and says the exit status: mpirun ends
/// everybody, the speaker too, as soon as any rank has failed.
int front_door(int argc, char** argv) {
  const bool speaks = parray::rank_in_environment() == 0;
  if (speaks) {
    parray::install_signal_handlers();
  }
  CLI::App app(about, program);
  app.footer(footer);
  app.set_version_flag("--version", std::string(program) + " " + PARRAY_VERSION);
  parray::MpiOptions options;
  options.add_to(app);
  try {
    app.parse(argc, argv);
  } catch (const CLI::Success& asked) {  // --help, --version
    return speaks ? parray::checked_output(program, app.exit(asked, std::cout, std::cerr)) : 0;
  } catch (const CLI::ParseError& error) {
    return speaks ? parray::fail(program, 2, parray::usage_message(app, error)) : 0;
  }
  return parray::run_action(program, [&] { return parray::mpi_render(options); });
}

}  // namespace

int main(int argc, char** argv) {
  try {
    return front_door(argc, argv);
  } catch (...) {  // not even the message could be made
    return 1;
  }
}
