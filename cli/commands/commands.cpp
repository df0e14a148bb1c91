#include "cli/commands/commands.h"

namespace parray::commands {

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

}  // namespace parray::commands
