#pragma once

#include <functional>
#include <string>

#include "common/rooms.h"

namespace parray::process {

class CommandLine;

/// Does the work and returns the exit status. Throws InputError, RunError or Interrupted.
using Action = std::function<int()>;

/// A program as its --help presents it.
struct Program {
  const char* name;
  const char* about;
  const char* version;  ///< what --version prints
  bool speaks = true;   ///< false: of several processes with one command line another one prints
  const char* launcher = "";  ///< what the usage has before the name: "mpirun -n P "
};

/// What the main() of every program does around its work: `declare` adds options to the command
/// line and returns what is to be done once they are understood. Returns the exit status of
/// README.md (0 done, 1 failed, 2 bad usage or bad input, 130 interrupted); a failure is one line
/// on stderr. `declare` may be called several times, for --describe (describe.h). One that does not
/// speak returns 0 where the command line is at fault.
int run_main(const Program& program, int argc, const char* const* argv,
             const std::function<Action(CommandLine&)>& declare);

/// Prints "PROGRAM: message" as one line on stderr; returns `status`.
int fail(const char* program, int status, std::string message);

/// Does `action` and returns the exit status; what it throws becomes a line on stderr and the
/// status that its type stands for. What was printed has to arrive: a full disk behind stdout is a
/// failure, too.
int run_action(const char* program, const Action& action);

}  // namespace parray::process
