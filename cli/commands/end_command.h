#pragma once

#include <string>

#include "cli/farm/client.h"

namespace parray::commands {

/// Runs what the user wants to be run once a job has ended (--on-end), by the shell, and waits for
/// it. Its environment tells PARRAY_JOB (the number), PARRAY_STATE (done, failed or cancelled),
/// PARRAY_REASON and PARRAY_IMAGE (the file that was written; empty: none). Empty: does nothing.
/// A command that fails is told on stderr, and changes nothing else.
void run_end_command(const std::string& command, JobId job, const std::string& state,
                     const std::string& reason, const std::string& image);

}  // namespace parray::commands
