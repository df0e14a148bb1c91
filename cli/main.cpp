#include <iostream>

#include "cli/commands/commands.h"
#include "common/process/run_main.h"
#include "common/process/stop_signal.h"

namespace {

using namespace parray::commands;

constexpr Program parray_program = {
    "parray", "Render scenes of spheres, on this machine or on many", "parray " PARRAY_VERSION};

/// Adds all commands, in the order of the help.
void add_commands(CommandLine& line) {
  line.heading("Pictures");
  add_render(line);
  add_film(line);
  add_plan(line);
  add_tradeoff(line);
  add_compare(line);
  add_verify(line);
  line.heading("Scenes");
  add_validate(line);
  add_convert(line);
  line.heading("A farm of machines");
  add_submit(line);
  add_jobs(line);
  add_show(line);
  add_watch(line);
  add_steering(line);
  add_fetch(line);
  add_journal_commands(line);
  add_workers(line);
  add_keygen(line);
  line.heading("This machine");
  add_doctor(line);
  line.add_help_command();
}

int do_chosen(const CommandLine& line) {
  if (!line.chosen()) {
    std::cout << line.help();
    return 0;
  }
  return line.chosen()();
}

}  // namespace

int main(int argc, char** argv) {
  stop_at_signals();
  return run_main(parray_program, argc, argv, [&](CommandLine& line) {
    add_commands(line);
    line.example("parray render scenes/glass.json -o glass.png", "renders on this machine");
    line.example("parray validate atoms.xyz", "says what is in a file");
    line.example("parray submit scenes/glass.json --wait -o glass.png",
                 "renders on a farm (parray-coordinator, parray-worker)");
    return [&] { return do_chosen(line); };
  });
}
