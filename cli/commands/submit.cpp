#include <filesystem>
#include <iostream>
#include <memory>
#include <optional>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include "cli/commands/commands.h"
#include "cli/commands/farm.h"
#include "cli/commands/finishing_options.h"
#include "cli/commands/frame_scenes.h"
#include "cli/commands/options.h"
#include "cli/commands/prepare.h"
#include "cli/commands/rendering.h"
#include "cli/commands/series.h"
#include "cli/input/formats/format_table.h"
#include "cli/input/scene_file/camera_path.h"
#include "cli/output/picture/image_file.h"
#include "common/base/cpu_count.h"
#include "common/base/error.h"
#include "common/base/files.h"
#include "common/base/printable.h"
#include "common/process/stop_signal.h"
#include "common/scene/settings_fwd.h"

namespace parray::commands {
namespace {

namespace fs = std::filesystem;

struct SubmitCommand {
  std::string scene;
  RenderOptions render;
  OutputOptions output;
  FarmOptions farm;
  std::string name;  ///< empty: that of the scene's file
  std::uint32_t priority = 50;
  std::uint32_t max_failures = 0;  ///< 0: as the coordinator's --max-failures
  bool wait = false;
  ProgressOptions following;
  std::optional<FrameRange> frames;
  std::string camera_path;
};

RenderRequest request_of(const SubmitCommand& command) {
  const bool writes = !command.output.paths().image.empty();
  return {.mode = command.frames ? RenderMode::series
                  : writes       ? RenderMode::wait
                                 : RenderMode::submit,
          .scene = command.scene,
          .render = command.render,
          .output = command.output,
          .following = command.following,
          .threads = static_cast<std::uint32_t>(usable_cpus()),
          .priority = command.priority,
          .key_file = command.farm.key_file()};
}

/// Refuses a preview of a series before the command line asks for the --wait that a preview needs.
void refuse_preview(const ProgressOptions& following) {
  if (!following.preview.empty()) require(RenderMode::series, Feature::preview, "--preview");
  if (!following.display.empty()) require(RenderMode::series, Feature::preview, "--display");
}

/// Returns the token of a series. Numbered scenes contribute their names, other files their
/// contents.
std::string token_of(const SubmitCommand& command) {
  const FrameRange& frames = *command.frames;
  return series_token(
      fs::absolute(command.scene).lexically_normal().string() + "\n" +
      std::to_string(frames.first) + "-" + std::to_string(frames.last) + ":" +
      std::to_string(frames.step) + "\n" + command.render.as_given() +
      (has_frame_number(command.scene) ? "" : read_file(command.scene).value_or("")) + "\n" +
      (command.camera_path.empty() ? "" : read_file(command.camera_path).value_or("")));
}

/// Throws InputError if the scene is a file of particles, whose automatic camera would differ from
/// frame to frame.
void check_scene(const SubmitCommand& command) {
  if (has_frame_number(command.scene) || !command.camera_path.empty()) return;
  PackedFile file(command.scene);
  if (particle_format_of(file) != nullptr) {
    throw InputError(printable(command.scene, 4096) +
                     ": the automatic camera of a particle file differs from frame to frame: use "
                     "parray film --farm, which has one camera for all, or write a scene file with "
                     "parray convert, and submit that");
  }
}

/// Returns the input files of a series. `named`: also those that its scene files name.
InputFiles inputs_of(const SubmitCommand& command, bool named) {
  InputFiles inputs = inputs_of(request_of(command));
  inputs.add(command.camera_path);
  const bool numbered = has_frame_number(command.scene);
  for (std::uint32_t i = 0; i < (numbered ? command.frames->count() : 1); ++i) {
    const std::string scene = with_frame_number(command.scene, command.frames->number(i));
    inputs.add(scene);
    if (!named) continue;
    try {
      PackedFile file(scene);
      if (particle_format_of(file) != nullptr) continue;
      for (const auto& input : files_named_in(scene, NamedFiles::anywhere)) inputs.add(input);
    } catch (const InputError&) {
      continue;  // run_frames() gives the reason
    }
  }
  return inputs;
}

/// Throws InputError unless each frame has its own files, none of which is an input.
void check_series(const SubmitCommand& command, const OutputPaths& outputs) {
  if (outputs.none()) return;
  check_frame_outputs(outputs);
  std::vector<OutputPaths> numbered;
  bool exist = false;
  std::error_code ignored;
  for (std::uint32_t i = 0; i < command.frames->count(); ++i) {
    const OutputPaths& frame =
        numbered.emplace_back(outputs_of(outputs, command.frames->number(i)));
    exist = exist || fs::exists(frame.report, ignored);
  }
  // A report may have any name; pictures have extensions that no file of particles has. A file that
  // does not exist is no input. So most series need not read their scenes for this.
  const InputFiles inputs = inputs_of(command, exist);
  for (const OutputPaths& frame : numbered) check_not_inputs(frame, inputs);
}

/// Loads the frames of a series and submits them. With --wait and -o, fetches each frame when it is
/// done.
int submit_frames(const SubmitCommand& command) {
  const OutputPaths outputs = command.output.paths();
  check_series(command, outputs);
  check_request(request_of(command));
  FarmClient client(command.farm);
  check_scene(command);
  const DeferredInterrupts deferred;
  std::optional<CameraPath> path;
  if (!command.camera_path.empty()) path.emplace(command.camera_path);
  FrameJobs jobs;
  for (std::uint32_t i = 0; i < command.frames->count(); ++i) {
    jobs.frames.push_back(command.frames->number(i));
  }
  bool warned = false;
  jobs.load = [&](std::uint32_t frame) {
    FrameChange change;
    if (path) {
      change.camera = path->at(frame);
    } else if (!has_frame_number(command.scene)) {
      change.particles = frame;
    }
    LoadedSubmission loaded =
        load_submission(RenderMode::series, with_frame_number(command.scene, frame), command.render,
                        command.priority, change);
    if (!std::exchange(warned, true)) {
      warn_of_missing_postprocessing(loaded.rest.postprocessing, loaded.rest.labels.any(),
                                     command.scene, "render the frames one by one to have them");
    }
    Submission submission = std::move(loaded.submission);
    check_image_size(outputs.image, width_of(submission.settings), height_of(submission.settings));
    submission.max_failures = command.max_failures;
    if (!command.name.empty()) submission.name = command.name;
    return submission;
  };
  if (command.wait && !outputs.none()) {
    jobs.deliver = [&](std::uint32_t frame, JobId job) {
      return fetch_and_write(*client, job, outputs_of(outputs, frame));
    };
  }
  jobs.token = token_of(command);
  jobs.wait = command.wait;
  jobs.following = command.following;
  jobs.image = outputs.image.string();
  return run_frames(*client, jobs);
}

int submit(const SubmitCommand& command) {
  if (command.frames) return submit_frames(command);
  const Time started = SteadyClock().now();
  PreparedRender prepared = prepare(request_of(command));
  prepared.submission.max_failures = command.max_failures;
  if (!command.name.empty()) prepared.submission.name = command.name;
  const OutputPaths& outputs = prepared.outputs;
  if (command.wait && !outputs.none()) {
    reserve_time(prepared, [] { return 0.0; });  // the limit counts from the first lease
  }
  FarmClient client(command.farm);
  const Time submitted = SteadyClock().now();
  const JobId job = client->submit(std::move(prepared.submission));
  const double submit_seconds = to_seconds(SteadyClock().now() - submitted);
  std::cout << job << std::endl;
  if (!command.wait) return 0;
  const DeferredInterrupts deferred;
  try {
    if (outputs.none()) {
      wait_until_done(*client, job, command.following);
      return 0;
    }
    return wait_and_write(*client, job, outputs, command.following, prepared.extra,
                          CommandTimes{started, submit_seconds});
  } catch (const Interrupted&) {
    const std::string number = std::to_string(job);
    throw Interrupted("interrupted; job " + number + " continues: use parray watch " + number +
                      " or parray cancel " + number);
  }
}

}  // namespace

void add_submit(CommandLine& line) {
  Command command =
      line.command("submit", "Submit a scene to a coordinator; prints the number of the new job");
  const auto options = std::make_shared<SubmitCommand>();
  add_scene(command, options->scene);
  options->render.add_to(command);
  options->render.add_quality_to(command);
  options->render.add_like_to(command);
  options->output.add_to(command, false);
  options->output.add_aov_to(command);
  options->output.add_denoise_to(command, true);
  options->output.add_labels_to(command, options->render);
  std::array<Option, 3> following = add_following(command, options->following);
  command.section("Series of frames");
  const Option frames =
      command
          .option(
              "--frames",
              [options](const std::string& text) {
                options->frames = frame_range_from(text);
                refuse_preview(options->following);
              },
              "Submit a series of frames as one job. The numbers replace #### in the scene's name, "
              "and are frames of --camera-path. With neither, they are frames of the trajectory "
              "that the scene names (the first is 0). The same command again submits the frames "
              "that are still missing. With --wait, -o name-####.exr writes the pictures")
          .type_name("FIRST-LAST[:STEP]");
  add_camera_path(command, options->camera_path).needs(frames);
  command.section(farm_group);
  const Option wait = command.flag("--wait", options->wait, "Return when the job has ended");
  options->output.image_option().needs(wait);
  options->output.report_option().needs(wait);
  for (Option& option : following) option.needs(wait);
  command.option("--name", options->name, "Name of the job (default: the file name of the scene)")
      .type_name("TEXT")
      .forbid_empty();
  add_priority(command, options->priority);
  add_whole_number(
      command, "--max-failures", 1, 1000, options->max_failures,
      "The job fails if N machines that trace other parts of it have failed at the same part. It "
      "also fails if all machines have failed there, and they are at least N, or each has at least "
      "two failures for each of its workers (default: the coordinator's)");
  options->farm.add_to(command);
  command.example("parray submit scenes/glass.json", "prints the number of the job and returns");
  command.example(
      "parray submit scenes/glass.json --wait -o glass.exr --target-error 0.01",
      "stops when the error is at most 0.01 (RMSE, linear radiance), and writes the picture here");
  command.example("parray submit 'scene-####.json' --frames 1-120 --wait -o 'frame-####.exr'",
                  "renders a series of frames as one job");
  command.example("parray submit scenes/glass.json --coordinator tcp://farm:7400 --keys ann.key",
                  "submits to the coordinator at this address, with your key");
  command.runs(reading_answers([options] { return submit(*options); }));
}

}  // namespace parray::commands
