#include <memory>
#include <optional>
#include <vector>

#include "cli/commands/commands.h"
#include "cli/commands/options.h"
#include "cli/commands/render_views.h"
#include "cli/commands/rendering.h"
#include "cli/commands/time_reserve.h"
#include "cli/farm/embedded.h"
#include "cli/output/denoising.h"
#include "common/base/cpu_count.h"
#include "common/process/stop_signal.h"
#include "common/scene/scene_bytes.h"

namespace parray::commands {
namespace {

struct RenderCommand {
  std::string scene;
  RenderOptions render;
  OutputOptions output;
  std::optional<std::uint32_t> threads;
  Following following;
  std::vector<View> views;
};

std::uint32_t threads_of(const RenderCommand& command) {
  return command.threads.value_or(static_cast<std::uint32_t>(usable_cpus()));
}

int render(const RenderCommand& command) {
  if (!command.views.empty()) {
    return render_views({command.scene, command.views, command.render, command.output,
                         command.following, threads_of(command)});
  }
  const SteadyClock clock;
  const Time started = clock.now();
  OutputPaths outputs = command.output.paths(command.following);
  check_outputs(outputs, command.scene);
  Display::check(command.following.display);
  SceneFile file;
  Submission submission =
      load_for_outputs(command.scene, command.render, 50, command.output, outputs, file);
  check_isa(submission.settings.isa);
  submission.settings.progressive = command.following.shows_picture();
  if (outputs.denoise) ask_for_denoising(submission.settings, true);
  const DeferredInterrupts deferred;
  const std::uint32_t threads = threads_of(command);
  ExtraChannels extra =
      extra_channels(outputs.aovs, submission.settings, submission.scene, static_cast<int>(threads),
                     outputs.transparent, needs_of(outputs.finishing));
  EmbeddedFarm farm(
      threads, [&extra](const std::string& scene_id) { return denoised_judge(extra, scene_id); });
  extra.accelerators = farm.accelerators();
  if (outputs.denoise && !command.following.quiet) say_whether_denoising_pays(extra);
  if (submission.settings.time_limit > 0) {
    TimeShare share = whole_limit(outputs, submission.settings,
                                  [&] { return to_seconds(clock.now() - started); });
    submission.reserved_seconds =
        reserve_time(share, outputs, submission.settings, extra, scene_identity(*submission.scene));
  }
  const auto link = farm.connect();
  Client client(*link, clock, embedded_client(farm));
  try {
    const Time submitted = clock.now();
    const JobId job = client.submit(std::move(submission));
    return wait_and_deliver(client, job, outputs, command.following, extra,
                            CommandTimes{started, to_seconds(clock.now() - submitted), true});
  } catch (const Interrupted&) {
    stop_interrupted(farm);
    throw;
  }
}

}  // namespace

void add_render(CommandLine& line, Action& chosen) {
  Command command = line.command("render", "Render a scene on this machine");
  const auto options = std::make_shared<RenderCommand>();
  add_scene(command, options->scene);
  options->render.add_to(command);
  options->render.add_like_to(command);
  constexpr std::uint32_t most_threads = 4096;  // the protocol's
  add_whole_number(
      command, "--threads", 1, most_threads,
      [options](std::uint64_t value) { options->threads = static_cast<std::uint32_t>(value); },
      "Threads to trace with (default: every processor that may be used)")
      .group(work_group);
  command
      .option(
          "--views", [options](const std::string& text) { options->views = views_from(text); },
          "Several views, as front,top,iso, in one PNG picture: three side by side, more in rows; "
          "--width and --height are those of each")
      .words(view_words(), true)
      .type_name("VIEW,VIEW...")
      .group(particles_group);
  options->output.add_to(command, true);
  options->output.add_aov_to(command);
  options->output.add_denoise_to(command);
  options->output.add_labels_to(command, options->render);
  add_following(command, options->following);
  command.example("parray render scenes/glass.json -o glass.png",
                  "as the scene says, a bar of progress meanwhile");
  command.example("parray render scenes/particles/helix.pdb -o helix.png",
                  "the portrait of a molecule, framed and lit by itself");
  command.example(
      "parray render scenes/particles/helix.pdb -o helix.png --legend --scale-bar --width-mm 85",
      "for print, a column wide: what its colours mean, and a length");
  command.example(
      "parray render scenes/particles/helix.pdb -o views.png --views front,top,iso "
      "--style publication",
      "from three sides, for a paper: white, with outlines");
  command.example("parray render scenes/glass.json -o glass.exr --target-error 0.01",
                  "until the error is at most 0.01 (RMSE, linear radiance)");
  command.example("parray render scenes/glass.json -o glass.png --time-limit 10 --denoise",
                  "the best picture of ten seconds, its noise filtered away");
  command.example(
      "parray render scenes/glass.json -o glass.exr --aov depth,normal --report glass.json",
      "with named channels, and a report of what was done and how fast");
  command.on_chosen([options, &chosen] { chosen = [options] { return render(*options); }; });
}

}  // namespace parray::commands
