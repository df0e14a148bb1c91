#include <CLI/CLI.hpp>
#include <iostream>

#include "cli/commands/commands.h"
#include "cli/front_door.h"
#include "cli/interrupt.h"
#include "cli/usage_error.h"

namespace {

constexpr const char* about = "ParRay renders scenes of spheres, on this machine or on many.";
constexpr const char* footer =
    "\nparray COMMAND --help lists a command's options.\n"
    "Exit status: 0 done; 1 failed; 2 bad usage or bad input; 130 interrupted.";

constexpr const char* program = "parray";

int front_door(int argc, char** argv) {
  parray::install_signal_handlers();
  CLI::App app(about, "parray");
  app.footer(footer);
  app.set_version_flag("--version", "parray " PARRAY_VERSION);
  app.require_subcommand(0, 1);
  parray::Action action = [&app] {
    std::cout << app.help();
    return 0;
  };
  parray::add_commands(app, action);
  try {
    app.parse(argc, argv);
  } catch (const CLI::Success& asked) {  // --help, --version
    return parray::checked_output(program, app.exit(asked, std::cout, std::cerr));
  } catch (const CLI::ParseError& error) {
    return parray::fail(program, 2, parray::usage_message(app, error));
  }
  return parray::run_action(program, action);
}

}  // namespace

int main(int argc, char** argv) {
  try {
    return front_door(argc, argv);
  } catch (...) {  // not even the message could be made
    return 1;
  }
}
