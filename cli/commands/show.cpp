#include <memory>

#include "cli/commands/commands.h"
#include "cli/commands/farm.h"
#include "cli/commands/options.h"
#include "cli/commands/printing.h"

namespace parray {
namespace {

struct ShowCommand {
  std::uint64_t job = 0;
  FarmOptions farm;
  bool as_json = false;
};

int show(const ShowCommand& command) {
  FarmClient client(command.farm);
  print_job(client->show(command.job), command.as_json);
  return 0;
}

}  // namespace

void add_show(CommandLine& line, Action& chosen) {
  Command command = line.command("show", "Show one job");
  const auto options = std::make_shared<ShowCommand>();
  add_job(command, options->job);
  add_json(command, options->as_json);
  options->farm.add_to(command);
  command.on_chosen([options, &chosen] { chosen = [options] { return show(*options); }; });
}

}  // namespace parray
