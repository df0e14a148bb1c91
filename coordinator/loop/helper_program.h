#pragma once

#include <spawn.h>
#include <sys/types.h>

#include <filesystem>
#include <string>
#include <vector>

#include "common/rooms.h"

/// Programs that the coordinator runs for work that must not endanger it: parray-http-child,
/// parray-referee.
namespace parray::coordinator {

/// Returns where a helper lies beside this program: bin/../lib/parray/NAME, both where it is built
/// and where it is installed. The file may be missing.
std::filesystem::path helper_program(const std::string& name);

/// Starts `arguments[0]` in a process group of its own, with default signals, few variables of the
/// environment and at most `threads` threads of OpenMP. `files` says what it has open. Any thread.
/// Throws RunError.
pid_t start_helper(std::vector<std::string> arguments, const posix_spawn_file_actions_t& files,
                   int threads);

}  // namespace parray::coordinator
