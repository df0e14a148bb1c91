#include <algorithm>
#include <memory>
#include <utility>

#include "cli/commands/commands.h"
#include "cli/commands/farm.h"
#include "cli/commands/options.h"
#include "cli/delivery.h"
#include "cli/extra_channels.h"
#include "cli/interrupt.h"
#include "common/base/error.h"

namespace parray {
namespace {

struct FetchCommand {
  std::uint64_t job = 0;
  OutputOptions output;
  FarmOptions farm;
};

int fetch(const FetchCommand& command) {
  const Aovs aovs = command.output.paths().aovs;
  if (!std::all_of(aovs.begin(), aovs.end(), is_statistic)) {
    throw InputError("--aov " + text_of(aovs) +
                     ": fetch has no scene to trace: samples and half-width only; the others come "
                     "with render or submit --wait");
  }
  check_outputs(command.output.paths());
  FarmClient client(command.farm.address());
  const DeferredInterrupts deferred;
  Picture picture = client->fetch(command.job, wants_statistics(aovs));
  add_channels(picture, extra_channels(aovs, {}, {}, 1));
  return deliver(std::move(picture), command.output.paths(), {});
}

}  // namespace

void add_fetch(CLI::App& app, Action& chosen) {
  auto* command = app.add_subcommand("fetch", "Write the picture of a job that is done");
  const auto options = std::make_shared<FetchCommand>();
  add_job(*command, options->job);
  options->output.add_to(*command, true);
  options->output.add_aov_to(*command);
  options->farm.add_to(*command);
  command->callback([options, &chosen] { chosen = [options] { return fetch(*options); }; });
}

}  // namespace parray
