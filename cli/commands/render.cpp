#include <iostream>
#include <memory>
#include <optional>
#include <vector>

#include "cli/commands/commands.h"
#include "cli/commands/options.h"
#include "cli/commands/prepare.h"
#include "cli/commands/render_views.h"
#include "cli/commands/rendering.h"
#include "cli/farm/embedded.h"
#include "cli/measure/plan/denoising_worth.h"
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
  ProgressOptions following;
  std::vector<View> views;
};

RenderRequest request_of(const RenderCommand& command, RenderMode mode) {
  return {.mode = mode,
          .scene = command.scene,
          .render = command.render,
          .output = command.output,
          .following = command.following,
          .threads = command.threads.value_or(static_cast<std::uint32_t>(usable_cpus()))};
}

/// Traces a part of the picture. Says on stderr if denoising is not expected to pay
/// (cli/measure/plan/denoising_worth.h).
void say_whether_denoising_pays(const ExtraChannels& extra) {
  const auto tracer = tracer_of(extra, scene_identity(*extra.scene));
  const auto worth = denoising_worth(*tracer, *extra.scene, extra.settings, extra.threads);
  if (worth && !worth->pays()) std::cerr << "parray: " + denoising_does_not_pay(*worth) + "\n";
}

int render(const RenderCommand& command) {
  if (!command.views.empty()) {
    return render_views(request_of(command, RenderMode::sheet), command.views);
  }
  const SteadyClock clock;
  const Time started = clock.now();
  const RenderRequest request = request_of(command, RenderMode::render);
  PreparedRender prepared = prepare(request);
  ExtraChannels& extra = prepared.extra;
  const DeferredInterrupts deferred;
  EmbeddedFarm farm(request.threads, [&extra](const std::string& scene_id) {
    return denoised_judge(extra, scene_id);
  });
  extra.accelerators = farm.accelerators();
  if (prepared.outputs.denoise && !command.following.quiet) say_whether_denoising_pays(extra);
  reserve_time(prepared, [&] { return to_seconds(clock.now() - started); });
  const auto link = farm.connect();
  Client client(*link, clock, embedded_client(farm));
  try {
    const Time submitted = clock.now();
    const JobId job = client.submit(std::move(prepared.submission));
    return wait_and_write(client, job, prepared.outputs, command.following, extra,
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
