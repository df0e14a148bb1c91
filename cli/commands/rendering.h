#pragma once

#include <optional>
#include <string>

#include "cli/commands/loading.h"
#include "cli/commands/options.h"
#include "cli/farm/client.h"
#include "cli/farm/embedded.h"
#include "cli/output/delivery.h"
#include "cli/output/extra_channels.h"
#include "cli/output/preview.h"

/// The steps that `render`, `submit`, `watch` and `fetch` share.
namespace parray::commands {

/// Lays down that the picture is to be denoised, and that a target counts it then. Throws
/// InputError where nobody can tell the error of a denoised picture in time: `can_judge`, whoever
/// decides on passes can.
void ask_for_denoising(RenderSettings& settings, bool can_judge);

/// Says on stderr if denoising is not expected to pay (cli/measure/plan/denoising_worth.h), after
/// tracing a part of the picture. Builds the accelerator, or takes that of `extra`.
void say_whether_denoising_pays(const ExtraChannels& extra);

/// Loads a scene, lays the options over its settings, decides what was left automatic and encodes
/// it. `rest`, if not null, becomes what was loaded, of its scene
/// the camera alone. Throws InputError.
Submission load_submission(const std::string& scene_file, const RenderOptions& options,
                           std::uint32_t priority, const FrameChange& change = {},
                           NamedFiles named = NamedFiles::anywhere, SceneFile* rest = nullptr);

/// The same for a command that may write the picture: `outputs` get what the scene asks for beside
/// the options, notes, labels and finishing, and whether the background is taken out.
Submission load_for_outputs(const std::string& scene_file, const RenderOptions& options,
                            std::uint32_t priority, const OutputOptions& output,
                            OutputPaths& outputs, SceneFile& rest);

/// Of a client of a farm in this process.
Client::Options embedded_client(const EmbeddedFarm& farm);

/// After an interruption: stops the farm. Where one of its threads is deep in a step that cannot be
/// cut short the process ends here: it holds nothing but memory.
void stop_interrupted(EmbeddedFarm& farm);

/// How soon to look again after a job that has been waited for so long.
Time next_look(Time waited);

/// Throws InputError, with that remedy, where a picture without its background is asked for: of
/// commands that do not write it.
void refuse_transparency(const Submission& submission, const std::string& remedy);

/// Throws InputError unless this machine has the instruction set.
void check_isa(Isa isa);

/// Shows a job's progress on stderr, and its picture where one is to follow, until it is done.
/// Throws RunError when it fails or is cancelled.
void wait_until_done(Client& client, JobId job, const Following& following);

/// The picture of a job that is done, with the statistics that `outputs` are to hold.
Picture fetch_picture(Client& client, JobId job, const OutputPaths& outputs);

/// wait_until_done(), then fetches, adds the extra channels and delivers. Returns the exit status;
/// `times` as deliver() has them.
int wait_and_deliver(Client& client, JobId job, const OutputPaths& outputs,
                     const Following& following, const ExtraChannels& extra,
                     std::optional<CommandTimes> times);

}  // namespace parray::commands
