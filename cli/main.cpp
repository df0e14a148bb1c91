#include <iostream>
#include <nlohmann/json.hpp>

#include "cli/commands/commands.h"
#include "common/base/error.h"
#include "common/process/stop_signal.h"

namespace {

using namespace parray::commands;

constexpr Program parray_program = {
    "parray", "Render scenes of spheres, on this machine or on many", "parray " PARRAY_VERSION};

/// Adds all commands, in the order of the help.
void add_commands(CommandLine& line, Action& chosen) {
  line.heading("Pictures");
  add_render(line, chosen);
  add_film(line, chosen);
  add_plan(line, chosen);
  add_tradeoff(line, chosen);
  add_compare(line, chosen);
  add_verify(line, chosen);
  line.heading("Scenes");
  add_validate(line, chosen);
  add_convert(line, chosen);
  line.heading("A farm of machines");
  add_submit(line, chosen);
  add_jobs(line, chosen);
  add_show(line, chosen);
  add_watch(line, chosen);
  add_steering(line, chosen);
  add_fetch(line, chosen);
  add_journal_commands(line, chosen);
  add_workers(line, chosen);
  add_keygen(line, chosen);
  line.heading("This machine");
  add_doctor(line, chosen);
  line.add_help_command();
}

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
