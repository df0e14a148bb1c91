#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "common/process/child.h"
#include "proto/clock.h"

namespace parray::child_process {

/// Runs the program `arguments[0]` (a path) without input and with `variables` (NAME=VALUE) added
/// to the environment. Its stdout and stderr replace the contents of the file `log`. Waits until
/// the child ends, at most for the duration `limit`.
///
/// If the child runs longer, or a signal interrupts this program, sends SIGTERM to the child's
/// process group. If the child itself still runs five seconds later, sends SIGKILL to the group.
/// Then returns with ChildEnd::timed_out set, or throws Interrupted after a signal. Throws RunError
/// if the program cannot be started.
ChildEnd run_child(const std::vector<std::string>& arguments,
                   const std::vector<std::string>& variables, const std::filesystem::path& log,
                   Time limit);

}  // namespace parray::child_process
