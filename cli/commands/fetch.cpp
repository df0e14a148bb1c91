#include <algorithm>
#include <memory>
#include <utility>

#include "cli/commands/commands.h"
#include "cli/commands/farm.h"
#include "cli/commands/options.h"
#include "cli/commands/rendering.h"
#include "cli/commands/series.h"
#include "cli/output/delivery.h"
#include "cli/output/extra_channels.h"
#include "common/base/error.h"
#include "common/process/stop_signal.h"

namespace parray::commands {
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
  const bool series = has_frame_number(command.output.paths().image.string());
  if (!series) check_outputs(command.output.paths());
  FarmClient client(command.farm);
  const DeferredInterrupts deferred;
  if (series) return fetch_series(*client, command.job, command.output.paths());
  Picture picture = fetch_picture(*client, command.job, command.output.paths());
  add_channels(picture, extra_channels(aovs, {}, {}, 1));
  return deliver(std::move(picture), command.output.paths(), {});
}

}  // namespace

void add_fetch(CommandLine& line, Action& chosen) {
  Command command = line.command("fetch",
                                 "Write the picture of a job that is done, or of all done frames "
                                 "of a series (-o name-####.exr)");
  const auto options = std::make_shared<FetchCommand>();
  add_job(command, options->job);
  options->output.add_to(command, true);
  options->output.add_aov_to(command);
  options->farm.add_to(command);
  command.example("parray fetch 7 -o glass.exr", "the picture, once the job is done");
  command.example("parray fetch 7 -o 'frame-####.png'", "the frames of a series that are done");
  command.on_chosen([options, &chosen] { chosen = [options] { return fetch(*options); }; });
}

}  // namespace parray::commands
