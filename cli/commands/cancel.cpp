#include <memory>

#include "cli/commands/commands.h"
#include "cli/commands/farm.h"
#include "cli/commands/options.h"
#include "cli/commands/printing.h"

namespace parray {
namespace {

struct CancelCommand {
  std::uint64_t job = 0;
  FarmOptions farm;
  bool as_json = false;
};

int cancel(const CancelCommand& command) {
  FarmClient client(command.farm.address());
  print_job(client->cancel(command.job), command.as_json);
  return 0;
}

}  // namespace

void add_cancel(CLI::App& app, Action& chosen) {
  auto* command = app.add_subcommand("cancel", "Cancel a job; one that has ended stays as it is");
  const auto options = std::make_shared<CancelCommand>();
  add_job(*command, options->job);
  add_json(*command, options->as_json);
  options->farm.add_to(*command);
  command->callback([options, &chosen] { chosen = [options] { return cancel(*options); }; });
}

}  // namespace parray
