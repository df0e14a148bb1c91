#pragma once

#include <optional>
#include <string>

#include "cli/farm/client.h"
#include "cli/farm/embedded.h"
#include "cli/output/extra_channels.h"
#include "cli/output/preview.h"
#include "cli/output/write_outputs.h"

/// The steps that `render`, `submit`, `watch` and `fetch` share.
namespace parray::commands {

/// Of a client of a farm in this process.
Client::Options embedded_client(const EmbeddedFarm& farm);

/// After an interruption: stops the farm. Where one of its threads is deep in a step that cannot be
/// cut short the process ends here: it holds nothing but memory.
void stop_interrupted(EmbeddedFarm& farm);

/// Runs the command of --on-end in the shell and waits for it; does nothing if `command` is empty.
/// The environment of the command has PARRAY_JOB (the number), PARRAY_STATE (done, failed or
/// cancelled), PARRAY_REASON and PARRAY_IMAGE (the picture file; empty: none). If the command
/// fails, a line on stderr says so.
void run_end_command(const std::string& command, JobId job, const std::string& state,
                     const std::string& reason, const std::string& image);

/// How soon to look again after a job that has been waited for so long.
Time next_look(Time waited);

/// Shows a job's progress on stderr, and its picture where one is to follow, until it is done.
/// Throws RunError when it fails or is cancelled.
void wait_until_done(Client& client, JobId job, const ProgressOptions& following);

/// The picture of a job that is done, with the statistics that `outputs` are to hold.
Picture fetch_picture(Client& client, JobId job, const OutputPaths& outputs);

/// wait_until_done(), then fetches, adds the extra channels and delivers. Returns the exit status;
/// `times` as write_outputs() has them.
int wait_and_write(Client& client, JobId job, const OutputPaths& outputs,
                   const ProgressOptions& following, const ExtraChannels& extra,
                   std::optional<CommandTimes> times);

}  // namespace parray::commands
