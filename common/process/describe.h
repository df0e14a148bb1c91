#pragma once

#include <functional>
#include <string>
#include <vector>

#include "common/process/description.h"

/// The hidden option `--describe json` of every program. cmake/pages.py makes man pages and shell
/// completion from its output.
namespace parray::process {

class CommandLine;

/// Returns the commands, options and examples of a program as JSON. `declare` declares them on a
/// new command line, and is called once more for each example. `program`: its name. `about`: one
/// line about the program. Throws RunError if the program does not understand one of its examples.
std::string describe(const std::function<void(CommandLine&)>& declare, const std::string& program,
                     const std::string& about);

/// Splits a command into words at spaces as a shell does, with '...' and "...". A # or & at the
/// beginning of a word ends the command. Backslashes have no special meaning.
std::vector<std::string> shell_words(const std::string& command);

}  // namespace parray::process
