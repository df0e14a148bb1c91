#pragma once

#include <optional>
#include <string>

#include "cli/farm/client.h"
#include "cli/farm/embedded.h"
#include "cli/output/extra_channels.h"
#include "cli/output/preview.h"
#include "cli/output/write_outputs.h"

/// The steps of a render after its submission as a job.
namespace parray::commands {

/// Returns options for a client of a farm in this process. `farm` must outlive the client.
Client::Options embedded_client(const EmbeddedFarm& farm);

/// Stops the farm after an interrupt of the user. If a thread of the farm still runs after 0.5 s,
/// ends the process with interrupted_status. Nothing is lost then, because this farm keeps no
/// files.
void stop_interrupted(EmbeddedFarm& farm);

/// Runs the command of --on-end in the shell and waits for it; does nothing if `command` is empty.
/// The environment of the command has PARRAY_JOB (the number), PARRAY_STATE (done, failed or
/// cancelled), PARRAY_REASON and PARRAY_IMAGE (the picture file; empty: none). If the command
/// fails, a line on stderr says so.
void run_end_command(const std::string& command, JobId job, const std::string& state,
                     const std::string& reason, const std::string& image);

/// Returns the time until the next request about a job: 2 % of `waited`, but at least 2 ms and at
/// most 100 ms. `waited`: time since the command began to wait for the job.
Time polling_interval(Time waited);

/// Shows the progress of a job on stderr, and its unfinished picture by --preview and --display,
/// until the job ends. Then runs the command of --on-end. Throws RunError if the job fails or is
/// cancelled. Otherwise replaces the unfinished picture by the finished one.
void wait_until_done(Client& client, JobId job, const ProgressOptions& following);

/// Fetches the picture of a finished job, with the statistics that `outputs` need.
Picture fetch_picture(Client& client, JobId job, const OutputPaths& outputs);

/// Fetches the picture of a finished job and writes the files. Denoises the picture and draws on it
/// if the job asks for that. `raw`: does not denoise. Returns the exit status. Throws InputError if
/// the coordinator does not give the scene that denoising and drawing need (Client::scene()).
int fetch_and_write(Client& client, JobId job, OutputPaths outputs, bool raw = false);

/// Waits as wait_until_done() does, fetches the picture, adds the extra channels and writes the
/// files. Then runs the command of --on-end, also after a RunError. Returns the exit status.
/// `times`: see write_outputs().
int wait_and_write(Client& client, JobId job, const OutputPaths& outputs,
                   const ProgressOptions& following, const ExtraChannels& extra,
                   std::optional<CommandTimes> times);

}  // namespace parray::commands
