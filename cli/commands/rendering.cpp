#include "cli/commands/rendering.h"

#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <iostream>
#include <string_view>
#include <utility>

#include "cli/commands/drawing.h"
#include "cli/commands/printing.h"
#include "cli/measure/plan/denoising_worth.h"
#include "cli/output/picture/image_file.h"
#include "cli/output/progress.h"
#include "cli/output/recipe.h"
#include "common/base/ascii.h"
#include "common/base/bands.h"
#include "common/base/cpu_count.h"
#include "common/base/error.h"
#include "common/base/printable.h"
#include "common/process/stop_signal.h"

namespace parray::commands {
Client::Options embedded_client(const EmbeddedFarm& farm) {
  return {.address = "this process",
          // farm.check() reports a lost farm, so a long silence only means that it is busy.
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

Time polling_interval(Time waited) {
  return std::clamp(waited / 50, Time(milliseconds(2)), Time(milliseconds(100)));
}

/// Returns whether mpirun sets this variable for its ranks. Parameters of a user (OMPI_MCA_btl,
/// OMPI_MCA_orte_default_hostfile, PMIX_MCA_gds) are not among these.
static bool marks_rank(std::string_view name) {
  constexpr auto marks = std::to_array<std::string_view>(
      {"OMPI_APP_CTX_", "OMPI_ARGV", "OMPI_COMM", "OMPI_FILE_LOCATION", "OMPI_FIRST_RANKS",
       "OMPI_MCA_ess", "OMPI_MCA_initial_wdir", "OMPI_MCA_orte_ess_", "OMPI_MCA_pmix",
       "OMPI_NUM_APP_CTX", "OMPI_UNIVERSE_SIZE", "PMIX_"});
  constexpr auto of_runtime = std::to_array<std::string_view>(
      {"app_num", "bound_at_launch", "hnp_uri", "jobfam_session_dir", "launch", "local_daemon_uri",
       "num_nodes", "precondition_transports", "top_session_dir"});
  constexpr std::string_view runtime = "OMPI_MCA_orte_";
  if (name.starts_with("PMIX_MCA_")) return false;
  const auto is_start = [name](std::string_view mark) { return name.starts_with(mark); };
  return std::ranges::any_of(marks, is_start) ||
         (is_start(runtime) &&
          std::ranges::find(of_runtime, name.substr(runtime.size())) != of_runtime.end());
}

/// Returns a command for the shell that first unsets the variables that make mpirun refuse to
/// start, then runs `command`. The variables of this process stay, because MPI may still read them.
static std::string without_rank(const std::string& command) {
  std::string names;
  for (const char* const* variable = environ; *variable != nullptr; ++variable) {
    const std::string_view text = *variable;
    const std::string_view name = text.substr(0, text.find('='));
    const bool plain =
        std::ranges::all_of(name, [](char c) { return c == '_' || ascii::is_letter_or_digit(c); });
    if (plain && marks_rank(name)) names += " " + std::string(name);
  }
  return names.empty() ? command : "unset" + names + "\n" + command;
}

void run_end_command(const std::string& command, JobId job, const std::string& state,
                     const std::string& reason, const std::string& image) {
  if (command.empty()) return;
  // Only this thread uses the environment: threads that trace do not read it.
  // NOLINTBEGIN(concurrency-mt-unsafe)
  setenv("PARRAY_JOB", std::to_string(job).c_str(), 1);
  setenv("PARRAY_STATE", printable(state).c_str(), 1);
  setenv("PARRAY_REASON", printable(reason, 2000).c_str(), 1);
  setenv("PARRAY_IMAGE", image.c_str(), 1);
  forget_wait_policy();
  const std::string words = without_rank(command);
  const int status = std::system(words.c_str());  // NOLINT(cert-env33-c): the user's own command
  // NOLINTEND(concurrency-mt-unsafe)
  if (status != 0) {
    std::cerr << "parray: the command of --on-end has failed: " << printable(command, 200) << "\n";
  }
}

/// For a job whose progress is not shown: prints once what the job waits for, after ten seconds.
class LongWait {
 public:
  explicit LongWait(bool quiet) : printed_(!quiet) {}

  void note(Time now, const JobStatus& status) {
    if (!since_ || status.waits_for.empty()) since_ = now;
    if (printed_ || now - *since_ < seconds(10)) return;
    printed_ = true;
    std::cerr << "parray: job " + std::to_string(status.id) +
                     " waits for: " + printable(status.waits_for, 500) + "\n";
  }

 private:
  bool printed_;
  std::optional<Time> since_;  ///< when the job began to wait
};

static JobStatus follow(Client& client, JobId job, const ProgressOptions& following,
                        Preview& preview) {
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
    preview.follow(clock, status, [&] { return client.fetch_partial(job).image; });
    client.rest(polling_interval(now - begin));
  }
}

static void require_done(const JobStatus& status) {
  if (status.state != name_of(JobState::done)) {
    throw RunError("job " + std::to_string(status.id) +
                   (status.state == name_of(JobState::cancelled) ? " was " : " ") + status.state +
                   (status.reason.empty() ? "" : ": " + printable(status.reason, 500)));
  }
}

void wait_until_done(Client& client, JobId job, const ProgressOptions& following) {
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

/// Returns the scene of a job, for denoising and labels.
static Client::JobScene scene_for_picture(Client& client, JobId job) {
  try {
    return client.scene(job);
  } catch (const InputError& error) {
    throw InputError(std::string(error.what()) + "; parray fetch " + std::to_string(job) +
                     " -o IMAGE.exr --raw does not need the scene");
  }
}

int fetch_and_write(Client& client, JobId job, OutputPaths outputs, bool raw) {
  const JobStatus status = job_status(client.show(job));
  const bool drawn = status.drawn && outputs.shows_postprocessing();
  outputs.denoise = status.denoise && !raw;
  ExtraChannels extra = extra_channels(outputs);
  if (outputs.denoise || drawn) {
    const Client::JobScene scene = scene_for_picture(client, job);
    if (drawn) add_drawing(outputs, scene.drawing, scene.scene, scene.settings);
    extra = extra_channels(outputs, scene.settings, scene.scene, static_cast<int>(usable_cpus()));
    extra.denoise = outputs.denoise;
  }
  Picture picture = fetch_picture(client, job, outputs);
  add_channels(picture, extra);
  return write_outputs(std::move(picture), outputs, {});
}

int wait_and_write(Client& client, JobId job, const OutputPaths& outputs,
                   const ProgressOptions& following, const ExtraChannels& extra,
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
    const int result = write_outputs(std::move(picture), outputs, times);
    end(status.state, "");
    return result;
  } catch (const RunError& error) {
    const bool done = status.state == name_of(JobState::done);
    end(done ? "failed" : status.state, done ? error.what() : status.reason);
    throw;
  }
}

}  // namespace parray::commands
