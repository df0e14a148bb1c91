#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "common/process/child.h"
#include "proto/clock.h"

namespace parray::child_process {

/// Runs the program `arguments[0]` (a path) without input and with `variables` (NAME=VALUE) added
/// to the environment. Its output goes to the file `log`. After `limit`, or when a signal
/// interrupts this program, ends the child's whole group: by SIGTERM, after five seconds by
/// SIGKILL. Throws RunError if the program cannot be started, Interrupted after a signal.
ChildEnd run_child(const std::vector<std::string>& arguments,
                   const std::vector<std::string>& variables, const std::filesystem::path& log,
                   Time limit);

}  // namespace parray::child_process
