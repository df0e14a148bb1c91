#include "cli/commands/rendering.h"

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <iostream>
#include <utility>

#include "cli/commands/end_command.h"
#include "cli/commands/finish_options.h"
#include "cli/commands/label_options.h"
#include "cli/commands/printing.h"
#include "cli/input/particles/packed_file.h"
#include "cli/measure/plan/denoising_worth.h"
#include "cli/output/picture/image_file.h"
#include "cli/output/progress.h"
#include "cli/output/recipe.h"
#include "cli/output/text.h"
#include "common/adaptive/rounding_limit.h"
#include "common/base/cpu_count.h"
#include "common/base/error.h"
#include "common/base/printable.h"
#include "common/process/stop_signal.h"
#include "common/scene/largest_radiance.h"
#include "common/scene/requirements.h"
#include "common/scene/scene_bytes.h"
#include "common/trace/isa.h"
#include "coordinator/jobs/report.h"

namespace parray::commands {
namespace {

/// load_scene(), by the recipe of --like if there is one: `original_sha256` is its picture's then.
SceneFile load_like(const std::string& scene_file, RenderOptions options, const FrameChange& change,
                    NamedFiles named, std::string& original_sha256) {
  if (options.like().empty()) return load_scene(scene_file, options, change, named);
  options.check_like();
  const std::string picture = printable(options.like(), 4096);
  const Recipe recipe = recipe_in(read_image(options.like()).metadata, picture);
  options.follow(recipe.settings, !recipe.transparent_sha256.empty());
  SceneFile file = load_scene(scene_file, options, {}, named);
  check_recipe(recipe, picture, scene_identity(file.scene), printable(scene_file, 4096));
  original_sha256 = recipe.image_sha256;
  return file;
}

}  // namespace

Submission load_for_outputs(const std::string& scene_file, const RenderOptions& options,
                            std::uint32_t priority, const OutputOptions& output,
                            OutputPaths& outputs, SceneFile& rest) {
  Submission submission =
      load_submission(scene_file, options, priority, {}, NamedFiles::anywhere, &rest);
  outputs.notes = notes_json(rest.particle_files);
  outputs.transparent = submission.transparent;
  outputs.original = {printable(options.like(), 4096), submission.original_sha256};
  if (outputs.transparent && !outputs.image.empty() && !can_hold_alpha(outputs.image)) {
    throw InputError(outputs.image.string() +
                     ": JPEG has no transparency: write .png, .tif, .jp2 or .exr");
  }
  add_labels(outputs, output.labels(), rest, submission.settings);
  add_finishing(outputs, output.finish(), rest, submission.scene, submission.settings);
  return submission;
}

Client::Options embedded_client(const EmbeddedFarm& farm) {
  return {.address = "this process",
          // It cannot be lost without farm.check() saying so; it may be busy for long.
          .timeout = std::chrono::hours(24),
          .poll = [&farm] {
            check_interrupted();
            farm.check();
          }};
}

void stop_interrupted(EmbeddedFarm& farm) {
  if (farm.stop(milliseconds(500))) return;
  std::cerr << "parray: interrupted" << std::endl;
  std::_Exit(interrupted_status);
}

/// A picture that is soon done is asked for often, one that takes an hour hardly ever: waiting adds
/// at most a fiftieth to the time that a job takes.
Time next_look(Time waited) {
  return std::clamp(waited / 50, Time(milliseconds(2)), Time(milliseconds(100)));
}

void ask_for_denoising(RenderSettings& settings, bool can_judge) {
  settings.replicates = true;
  settings.target_denoised = settings.target_error > 0 && settings.passes.empty();
  if (!settings.target_denoised) return;
  if (!can_judge) {
    throw InputError(
        "--target-error with --denoise: the error of the denoised picture is known to parray "
        "render alone while it renders: use that, or give --spp");
  }
  if (settings.target_half_width > 0) {
    throw InputError(
        "--target-error with --denoise and --target-half-width: a denoised picture states no "
        "half-widths: leave one of them out");
  }
}

Submission load_submission(const std::string& scene_file, const RenderOptions& options,
                           std::uint32_t priority, const FrameChange& change, NamedFiles named,
                           SceneFile* rest) {
  const SteadyClock clock;
  const Time begin = clock.now();
  Submission submission;
  SceneFile file = load_like(scene_file, options, change, named, submission.original_sha256);
  const ResolvedSettings resolved =
      resolve_settings(requirements_of(file.scene, usable_cpus()), file.settings);
  submission.scene = std::make_shared<const Scene>(std::move(file.scene));
  check_targets(resolved.settings, largest_radiance(*submission.scene));
  submission.name = scene_file == standard_input_argument
                        ? "standard input"
                        : printable(std::filesystem::path(scene_file).filename().string(), 100);
  submission.priority = priority;
  submission.settings = resolved.settings;
  submission.precision_reason = resolved.precision_reason;
  submission.duplicates_removed = file.duplicates.count;
  submission.transparent = file.transparent;
  submission.load_seconds = to_seconds(clock.now() - begin);
  if (rest != nullptr) {
    file.scene = Scene();
    file.scene.camera = submission.scene->camera;
    *rest = std::move(file);
  }
  return submission;
}

void refuse_transparency(const Submission& submission, const std::string& remedy) {
  if (!submission.transparent) return;
  throw InputError(submission.name + ": transparent: " + remedy);
}

void check_isa(Isa isa) {
  if (!runs_on_this_machine(isa)) {
    throw InputError("--isa " + std::string(name_of(isa)) +
                     ": this processor does not have it: use " + std::string(name_of(best_isa())) +
                     ", its best, or auto");
  }
}

void say_whether_denoising_pays(const ExtraChannels& extra) {
  const auto tracer = tracer_of(extra, scene_identity(*extra.scene));
  const auto worth = denoising_worth(*tracer, *extra.scene, extra.settings, extra.threads);
  if (worth && !worth->pays()) std::cerr << "parray: " + denoising_does_not_pay(*worth) + "\n";
}

/// Of a job whose progress nobody sees: says once what it has lacked for ten seconds.
class LongWait {
 public:
  explicit LongWait(bool quiet) : told_(!quiet) {}

  void note(Time now, const JobStatus& status) {
    if (!since_ || status.waits_for.empty()) since_ = now;
    if (told_ || now - *since_ < seconds(10)) return;
    told_ = true;
    std::cerr << "parray: job " + std::to_string(status.id) +
                     " waits for: " + printable(status.waits_for, 500) + "\n";
  }

 private:
  bool told_;
  std::optional<Time> since_;  ///< it has lacked something
};

/// Shows a job until it has ended.
static JobStatus follow(Client& client, JobId job, const Following& following, Preview& preview) {
  const SteadyClock clock;
  const Time begin = clock.now();
  Progress progress(progress_style(following.quiet, following.progress), std::cerr,
                    terminal_columns);
  LongWait waiting(following.quiet);
  for (;;) {
    JobStatus status = job_status(client.show(job));
    const Time now = clock.now();
    progress.show(now, status);
    if (status.ended()) return status;
    waiting.note(now, status);
    preview.follow(clock, status, [&] { return client.fetch_partial(job); });
    client.rest(next_look(now - begin));
  }
}

static void require_done(const JobStatus& status) {
  if (status.state != name_of(JobState::done)) {
    throw RunError("job " + std::to_string(status.id) + " was not finished: " + status.state +
                   (status.reason.empty() ? "" : ": " + printable(status.reason, 500)));
  }
}

void wait_until_done(Client& client, JobId job, const Following& following) {
  Preview preview(following);
  const JobStatus status = follow(client, job, following, preview);
  run_end_command(following.on_end, job, status.state, status.reason, "");
  require_done(status);
  if (!following.shows_picture()) return;
  const Picture picture = client.fetch(job, PictureDetail::image);
  if (!following.preview.empty()) write_picture(following.preview, picture);
  preview.finish(picture.image);
}

Picture fetch_picture(Client& client, JobId job, const OutputPaths& outputs) {
  Picture picture = client.fetch(job, outputs.wanted_detail());
  const bool lacks_samples = picture.statistics.samples.empty() &&
                             (can_hold_channels(outputs.image) || outputs.transparent) &&
                             samples_differ(picture.report);
  return lacks_samples ? client.fetch(job, PictureDetail::statistics) : picture;
}

int wait_and_deliver(Client& client, JobId job, const OutputPaths& outputs,
                     const Following& following, const ExtraChannels& extra,
                     std::optional<CommandTimes> times) {
  Preview preview(following);
  const JobStatus status = follow(client, job, following, preview);
  const auto end = [&](const std::string& state, const std::string& reason) {
    run_end_command(following.on_end, job, state, reason, outputs.image.string());
  };
  try {
    require_done(status);
    Picture picture = fetch_picture(client, job, outputs);
    add_channels(picture, extra);
    preview.finish(picture.image);
    const int result = deliver(std::move(picture), outputs, times);
    end(status.state, "");
    return result;
  } catch (const RunError& error) {
    const bool done = status.state == name_of(JobState::done);
    end(done ? "failed" : status.state, done ? error.what() : status.reason);
    throw;
  }
}

}  // namespace parray::commands
