#include "cli/commands/commands.h"

namespace parray {

void add_commands(CLI::App& app, Action& chosen) {
  add_render(app, chosen);
  add_submit(app, chosen);
  add_jobs(app, chosen);
  add_show(app, chosen);
  add_watch(app, chosen);
  add_cancel(app, chosen);
  add_fetch(app, chosen);
  add_workers(app, chosen);
  add_validate(app, chosen);
  add_convert(app, chosen);
  add_compare(app, chosen);
  add_plan(app, chosen);
  add_tradeoff(app, chosen);
  add_doctor(app, chosen);
}

}  // namespace parray
