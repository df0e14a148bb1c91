#include <memory>

#include "cli/commands/commands.h"
#include "cli/commands/farm.h"
#include "cli/commands/options.h"
#include "cli/delivery.h"
#include "cli/interrupt.h"

namespace parray {
namespace {

struct FetchCommand {
  std::uint64_t job = 0;
  OutputOptions output;
  FarmOptions farm;
};

int fetch(const FetchCommand& command) {
  check_outputs(command.output.paths());
  FarmClient client(command.farm.address());
  const DeferredInterrupts deferred;
  return deliver(client->fetch(command.job), command.output.paths(), {});
}

}  // namespace

void add_fetch(CLI::App& app, Action& chosen) {
  auto* command = app.add_subcommand("fetch", "Write the picture of a job that is done");
  const auto options = std::make_shared<FetchCommand>();
  add_job(*command, options->job);
  options->output.add_to(*command, true);
  options->farm.add_to(*command);
  command->callback([options, &chosen] { chosen = [options] { return fetch(*options); }; });
}

}  // namespace parray
