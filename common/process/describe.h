#pragma once

#include <functional>
#include <string>
#include <vector>

#include "common/process/description.h"

/// The hidden option --describe of every program, by which the build makes man pages and
/// completion.
namespace parray::process {

class CommandLine;

/// Does what `PROGRAM --describe TARGET` asks for: "json" prints the description; any other is a
/// directory, below which man/man1/*.1, bash-completion/completions/PROGRAM,
/// zsh/site-functions/_PROGRAM and fish/vendor_completions.d/PROGRAM.fish are written. `declare`
/// declares the options of a fresh command line. Throws RunError when an example of the help is
/// none that the program understands, or a file cannot be written.
void describe(const std::function<void(CommandLine&)>& declare, const std::string& program,
              const std::string& about, const std::string& target);

/// The words of a command as a shell reads it, with '...' and "..."; a # or & of its own ends it.
std::vector<std::string> shell_words(const std::string& command);

}  // namespace parray::process
