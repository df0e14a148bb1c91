#pragma once

#include <functional>
#include <string>

#include "common/rooms.h"

namespace parray::process {

class CommandLine;

/// The work of a program. Returns the exit status. Throws InputError, RunError or Interrupted.
using Action = std::function<int()>;

/// A program as its --help describes it.
struct Program {
  const char* name;
  const char* about;
  const char* version;        ///< what --version prints
  bool speaks = true;         ///< false: another process with the same command line prints
  const char* launcher = "";  ///< words before the name in the usage: "mpirun -n P "
};

/// The common part of every main(). `declare` adds options to the command line and returns the work
/// to do after parsing. Returns the exit status of README.md (0 done, 1 failed, 2 bad usage or bad
/// input, 130 interrupted). A failure prints one line on stderr. May call `declare` several times,
/// for --describe (describe.h). A program that does not speak returns 0 for a wrong command line.
int run_main(const Program& program, int argc, const char* const* argv,
             const std::function<Action(CommandLine&)>& declare);

/// Prints "PROGRAM: message" as one line on stderr; returns `status`.
int fail(const char* program, int status, std::string message);

/// Runs `action` and returns the exit status. An exception becomes a line on stderr and the status
/// of its type. A failed write to stdout, such as on a full disk, is a failure, too.
int run_action(const char* program, const Action& action);

}  // namespace parray::process
