#include <iostream>
#include <nlohmann/json.hpp>

#include "cli/commands/commands.h"
#include "common/base/error.h"
#include "common/process/stop_signal.h"

namespace {

using namespace parray;

constexpr Program parray_program = {"parray",
                                    "ParRay renders scenes of spheres, on this machine or on many.",
                                    "parray " PARRAY_VERSION};
constexpr const char* footer =
    "\nparray COMMAND --help lists a command's options.\n"
    "Exit status: 0 done; 1 failed; 2 bad usage or bad input; 130 interrupted.";

int do_chosen(const Action& chosen, const CommandLine& line) {
  if (!chosen) {
    std::cout << line.help();
    return 0;
  }
  try {
    return chosen();
  } catch (const nlohmann::json::exception& error) {
    throw RunError(std::string("reading the coordinator's answer: ") + error.what());
  }
}

}  // namespace

int main(int argc, char** argv) {
  stop_at_signals();
  Action chosen;
  return run_main(parray_program, argc, argv, [&](CommandLine& line) {
    line.footer(footer);
    add_commands(line, chosen);
    return [&] { return do_chosen(chosen, line); };
  });
}
