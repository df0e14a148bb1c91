#pragma once

#include <sys/types.h>

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "common/rooms.h"

/// Child processes. Only this file's source starts programs, except the user's --on-end command.
namespace parray::process {

/// A program to start and its surroundings.
struct ChildSetup {
  std::vector<std::string> arguments;    ///< the path of the program first
  std::vector<std::string> environment;  ///< all variables, as NAME=VALUE
  int input = -1;                        ///< file descriptor that becomes stdin; -1: no input
  std::filesystem::path output{};        ///< file for stdout; empty: discarded
  std::filesystem::path messages{};      ///< file for stderr; empty: this process's stderr
  std::filesystem::path directory{};     ///< current directory; empty: this process's
};

/// Starts a program in a process group of its own, with default signals and without other open
/// files of this process. Replaces the files for stdout and stderr, or makes them (mode 0600); both
/// may be the same file. Returns the process id. Any thread. Throws RunError if the program does
/// not start.
pid_t start_child(ChildSetup setup);

/// How a child has ended.
struct ChildEnd {
  int status = 0;  ///< exit status; 128 + signal if a signal ended it
  int signal = 0;  ///< the signal that ended it; 0: none
  // end_of_child() leaves the next two fields as they are; its callers may fill them.
  bool timed_out = false;  ///< it reached its time limit
  std::string message{};   ///< the last line that it wrote to stderr
};

/// Returns how the child has ended, or nothing if it still runs. Does not wait. Once it has
/// returned a result, do not call it again: the system may give the process id to another process.
std::optional<ChildEnd> end_of_child(pid_t child);

/// Returns this process's environment, with `variables` (NAME=VALUE) added or replaced.
std::vector<std::string> environment_with(const std::vector<std::string>& variables);

/// Returns the environment of a helper program with at most `threads` threads of OpenMP: LC_ALL=C,
/// limits for threads, and this process's search paths and sanitizer options. Threads reserve
/// address space that they never use, so helpers under a memory limit need few.
std::vector<std::string> helper_environment(int threads);

/// Returns the path of a helper program: bin/../lib/parray/NAME, relative to the directory of this
/// program, in a build and in an installation. The file may be missing.
std::filesystem::path helper_program(const std::string& name);

/// Returns whether this user may run `file`.
bool executable(const std::filesystem::path& file);

/// Returns the absolute path of the first executable file `name` in the directories of `path`
/// ("/usr/bin:/bin"); nothing if there is none.
std::optional<std::filesystem::path> find_program(const std::string& name, const std::string& path);

}  // namespace parray::process
