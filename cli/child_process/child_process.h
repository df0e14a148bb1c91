#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "proto/clock.h"

namespace parray::child_process {

/// A file that this user may run.
bool executable(const std::filesystem::path& file);

/// The first executable file `name` in the directories of `path` ("/usr/bin:/bin"), if any.
std::optional<std::filesystem::path> find_program(const std::string& name, const std::string& path);

/// How a child has ended.
struct ChildEnd {
  int status = 0;  ///< exit status; 128 + the signal that ended it
  bool timed_out = false;
};

/// Runs the program `arguments[0]` (a path) in a process group of its own, without input, its
/// output in the file `log`, with `variables` ("NAME=VALUE") added to the environment or in place
/// of what is there. After `limit`, or when a signal interrupts this program, the whole group is
/// ended: asked first, killed after five seconds.
/// Throws RunError when it cannot be started, Interrupted after a signal.
ChildEnd run_child(const std::vector<std::string>& arguments,
                   const std::vector<std::string>& variables, const std::filesystem::path& log,
                   Time limit);

}  // namespace parray::child_process
