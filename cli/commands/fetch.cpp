// Commands that follow a job or a series and write its pictures: watch and fetch.
#include <iostream>
#include <memory>

#include "cli/commands/commands.h"
#include "cli/commands/farm.h"
#include "cli/commands/options.h"
#include "cli/commands/prepare.h"
#include "cli/commands/rendering.h"
#include "cli/commands/series.h"
#include "cli/output/picture/image_file.h"
#include "cli/output/text.h"
#include "common/base/error.h"
#include "common/process/stop_signal.h"

namespace parray::commands {
namespace {

struct FetchCommand {
  std::uint64_t job = 0;
  bool partial = false;
  OutputOptions output;
  bool raw = false;
  FarmOptions farm;
};

int write_partial(const Picture& picture, const OutputPaths& outputs) {
  if (!outputs.report.empty() || !outputs.error_map.empty() || !outputs.aovs.empty()) {
    throw InputError(
        "the job is not done, and only the image of an incomplete picture can be written: leave "
        "out --report, --error-map and --aov");
  }
  write_image(outputs.image, picture.image,
              {{"Software", "ParRay " PARRAY_VERSION}, {"parray:partial", std::uint64_t{1}}});
  const auto pixels = static_cast<double>(picture.image.width) * picture.image.height;
  std::cerr << "parray: " << outputs.image.string()
            << " is incomplete: " << mean_text(picture.report.value("samples", 0.0) / pixels)
            << " samples per pixel\n";
  return 0;
}

int fetch(const FetchCommand& command) {
  const OutputPaths outputs = command.output.paths();
  check_request({RenderMode::fetch, {}, {}, command.output, {}, 1});
  const bool series = has_frame_number(outputs.image.string());
  if (series && command.partial) {
    throw InputError(
        "--partial writes one picture: give a file name without # and, for a frame of a series, "
        "the number of the frame's own job");
  }
  const InputFiles inputs{command.farm.key_file()};
  if (!series) check_outputs(outputs, inputs);
  FarmClient client(command.farm);
  const DeferredInterrupts deferred;
  if (series) return fetch_series(*client, command.job, outputs, inputs, command.raw);
  if (command.partial) {
    const Picture picture = client->fetch_partial(command.job);
    if (picture.report.value("partial", false)) return write_partial(picture, outputs);
  }
  return fetch_and_write(*client, command.job, outputs, command.raw);
}

struct WatchCommand {
  std::uint64_t job = 0;
  FarmOptions farm;
  ProgressOptions following;
};

int watch(const WatchCommand& command) {
  if (!command.following.preview.empty()) check_image_path(command.following.preview);
  InputFiles{command.farm.key_file()}.check(command.following.preview);
  check_display(command.following.display);
  FarmClient client(command.farm);
  wait_until_done(*client, command.job, command.following);
  return 0;
}

}  // namespace

void add_watch(CommandLine& line) {
  Command command = line.command(
      "watch", "Show a job's progress; returns when it ends: 0 if it is done, 1 if not");
  const auto options = std::make_shared<WatchCommand>();
  add_job(command, options->job);
  add_following(command, options->following);
  options->farm.add_to(command);
  command.example("parray watch 7", "shows progress until the job has ended");
  command.example("parray watch 7 --quiet --preview live.png",
                  "keeps live.png updated with the unfinished picture");
  command.runs(reading_answers([options] { return watch(*options); }));
}

void add_fetch(CommandLine& line) {
  Command command = line.command("fetch",
                                 "Write the picture of a finished job, or of the finished frames "
                                 "of a series (-o name-####.exr)");
  const auto options = std::make_shared<FetchCommand>();
  add_job(command, options->job);
  options->output.add_to(command, true);
  options->output.add_aov_to(command, false);
  command.flag("--partial", options->partial,
               "Write the incomplete picture of a job that is not done, also of a cancelled one");
  command.flag("--raw", options->raw,
               "Write the picture before denoising, for a job that was submitted with denoising");
  options->farm.add_to(command);
  command.example("parray fetch 7 -o glass.exr", "writes the picture of a finished job");
  command.example("parray fetch 7 -o 'frame-####.png'", "writes the finished frames of a series");
  command.example("parray fetch 7 --partial -o so-far.png",
                  "writes what a running, cancelled or failed job has");
  command.runs(reading_answers([options] { return fetch(*options); }));
}

}  // namespace parray::commands
