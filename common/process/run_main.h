#pragma once

#include <functional>
#include <string>

#include "common/process/command_line.h"

namespace parray::process {

/// The properties of a program that its --help shows.
struct Program {
  const char* name;           ///< also begins its messages
  const char* about;          ///< one line, without a full stop
  const char* version;        ///< output of --version
  bool speaks = true;         ///< false: another process with the same command line prints
  const char* launcher = "";  ///< words before the name in the usage: "mpirun -n P "
};

/// Does the common part of every program's main(). `declare` adds options to the command line and
/// returns the action that runs after parsing. Returns the exit status of README.md (0 done, 1
/// failed, 2 bad usage or bad input, 130 interrupted); a failure prints one line on stderr.
/// `declare` may be called several times, for --describe (description.h). A program with `speaks`
/// false returns 0 if the command line is wrong.
int run_main(const Program& program, int argc, const char* const* argv,
             const std::function<Action(CommandLine&)>& declare);

/// Prints "PROGRAM: message" as one line on stderr and returns `status`.
int fail(const char* program, int status, std::string message);

/// Runs `action` and returns the exit status. An exception becomes a line on stderr and a status: 2
/// for InputError, 130 for Interrupted, otherwise 1. A write error on stdout is a failure, too, for
/// example if the disk is full.
int run_action(const char* program, const Action& action);

}  // namespace parray::process
