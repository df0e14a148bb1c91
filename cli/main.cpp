#include <iostream>
#include <nlohmann/json.hpp>

#include "cli/commands/commands.h"
#include "common/base/error.h"
#include "common/process/stop_signal.h"

namespace {

using namespace parray::commands;

constexpr Program parray_program = {
    "parray", "Render scenes of spheres, on this machine or on many", "parray " PARRAY_VERSION};

int do_chosen(const Action& chosen, const CommandLine& line) {
  if (!chosen) {
    std::cout << line.help();
    return 0;
  }
  try {
    return chosen();
  } catch (const nlohmann::json::exception& error) {
    throw RunError(std::string("the coordinator's answer is damaged (") + error.what() +
                   "): use parray and parray-coordinator of the same release");
  }
}

}  // namespace

int main(int argc, char** argv) {
  stop_at_signals();
  Action chosen;
  return run_main(parray_program, argc, argv, [&](CommandLine& line) {
    add_commands(line, chosen);
    line.example("parray render scenes/glass.json -o glass.png", "renders on this machine");
    line.example("parray validate atoms.xyz", "says what is in a file");
    line.example("parray submit scenes/glass.json --wait -o glass.png",
                 "renders on a farm (parray-coordinator, parray-worker)");
    return [&] { return do_chosen(chosen, line); };
  });
}
