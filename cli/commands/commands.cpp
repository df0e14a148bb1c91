#include "cli/commands/commands.h"

namespace parray {

void add_commands(CommandLine& line, Action& chosen) {
  add_render(line, chosen);
  add_submit(line, chosen);
  add_jobs(line, chosen);
  add_show(line, chosen);
  add_watch(line, chosen);
  add_steering(line, chosen);
  add_fetch(line, chosen);
  add_journal_commands(line, chosen);
  add_workers(line, chosen);
  add_keygen(line, chosen);
  add_validate(line, chosen);
  add_convert(line, chosen);
  add_compare(line, chosen);
  add_verify(line, chosen);
  add_plan(line, chosen);
  add_tradeoff(line, chosen);
  add_doctor(line, chosen);
}

}  // namespace parray
