#include <memory>
#include <optional>
#include <utility>

#include "cli/commands/commands.h"
#include "cli/commands/farm.h"
#include "cli/commands/options.h"
#include "cli/commands/prepare.h"
#include "cli/commands/rendering.h"
#include "cli/commands/series.h"
#include "common/process/stop_signal.h"

namespace parray::commands {
namespace {

struct FetchCommand {
  std::uint64_t job = 0;
  OutputOptions output;
  std::optional<bool> denoise;
  FarmOptions farm;
};

int fetch(const FetchCommand& command) {
  const OutputPaths outputs = command.output.paths();
  check_request({RenderMode::fetch, {}, {}, command.output, {}, 1});
  const bool series = has_frame_number(outputs.image.string());
  if (!series) check_outputs(outputs);
  FarmClient client(command.farm);
  const DeferredInterrupts deferred;
  if (series) return fetch_series(*client, command.job, outputs, command.denoise);
  return fetch_and_write(*client, command.job, outputs, command.denoise);
}

}  // namespace

void add_fetch(CommandLine& line, Action& chosen) {
  Command command = line.command("fetch",
                                 "Write the picture of a finished job, or of the finished frames "
                                 "of a series (-o name-####.exr)");
  const auto options = std::make_shared<FetchCommand>();
  add_job(command, options->job);
  options->output.add_to(command, true);
  options->output.add_aov_to(command);
  command
      .on_off("--denoise", options->denoise,
              "Denoise the picture. An EXR file also stores the picture before denoising (default: "
              "on for a job that was submitted with --denoise, or by HTTP with denoise)")
      .group(output_group);
  options->farm.add_to(command);
  command.example("parray fetch 7 -o glass.exr", "writes the picture of a finished job");
  command.example("parray fetch 7 -o 'frame-####.png'", "writes the finished frames of a series");
  command.on_chosen([options, &chosen] { chosen = [options] { return fetch(*options); }; });
}

}  // namespace parray::commands
