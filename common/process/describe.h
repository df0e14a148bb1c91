#pragma once

#include <functional>
#include <string>
#include <vector>

#include "common/process/description.h"

/// The hidden option --describe of every program. The build makes man pages and completion scripts
/// with it.
namespace parray::process {

class CommandLine;

/// Implements `PROGRAM --describe TARGET`. The target "json" prints the description. Any other
/// target is a directory. The function writes man/man1/*.1, bash-completion/completions/PROGRAM,
/// zsh/site-functions/_PROGRAM and fish/vendor_completions.d/PROGRAM.fish below it. `declare`
/// declares the options of a new command line. Throws RunError if the program does not understand
/// an example of its help, or if a file cannot be written.
void describe(const std::function<void(CommandLine&)>& declare, const std::string& program,
              const std::string& about, const std::string& target);

/// Returns the words of a command as a shell reads it, with '...' and "...". A # or & as a word of
/// its own ends the command.
std::vector<std::string> shell_words(const std::string& command);

}  // namespace parray::process
