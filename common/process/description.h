#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <string>
#include <vector>

#include "common/rooms.h"

/// A command line as data: the source of --help, and of the hidden option `--describe json` of
/// every program. cmake/pages.py makes man pages and shell completion from the output of
/// --describe. CommandLine fills the data while options are declared.
namespace parray::process {

class CommandLine;

/// The candidates that a shell offers for a value besides known words.
enum class Completes : std::uint8_t { nothing, files, directories, jobs, commands };

/// An option, or a positional argument.
struct OptionText {
  std::vector<std::string> names;  ///< "-o", "--output"; empty for an argument
  std::string value;               ///< placeholder of the value; name of an argument; empty: a flag
  std::string text;                ///< what the option does, for the help
  std::string heading = "Options";
  std::string default_value{};  ///< empty: none, or `text` contains it
  std::string environment{};    ///< variable that applies if the option is not given; empty: none
  std::string with{};           ///< option that it requires; empty: none
  std::vector<std::string> words{};  ///< known words of the value
  bool list = false;                 ///< the value is several words, separated by commas
  Completes completes = Completes::nothing;
  bool required = false;
  bool repeats = false;  ///< may be given several times
  bool special = false;  ///< rarely needed: the --help of a command omits it

  [[nodiscard]] bool is_argument() const { return names.empty(); }
  /// Returns the form "-o, --output IMAGE".
  [[nodiscard]] std::string shown() const;
};

/// A command that users can copy. The build fails if its own program does not accept it.
struct Example {
  std::string command;
  std::string about;
};

/// A command with its options. For the program itself, `options` are those without a command.
struct CommandText {
  std::string name;                ///< with the program's: "parray render"
  std::string heading;             ///< heading in the list of commands
  std::string about;               ///< one line
  std::string launcher;            ///< before the name: "mpirun -n P "
  std::deque<OptionText> options;  ///< options and arguments, in order
  std::vector<Example> examples;

  /// Returns "render" of "parray render".
  [[nodiscard]] std::string word() const { return name.substr(name.rfind(' ') + 1); }
  /// Returns the usage: "parray render SCENE -o IMAGE [OPTION...]".
  [[nodiscard]] std::string usage(bool has_commands) const;
  /// Returns the name of its man page: "parray-render".
  [[nodiscard]] std::string page() const;
};

/// A program with its commands.
struct ProgramText {
  CommandText self;  ///< the program itself, with the options that need no command
  std::deque<CommandText> commands;
};

/// The meaning of every program's exit status.
inline constexpr const char* exit_statuses =
    "0 done; 1 failed; 2 bad usage or bad input; 130 interrupted";

/// Return the help of the whole program or of one of its commands. Lines have at most `columns`
/// characters, unless a word or an example is longer. `all`: include options that are rarely
/// needed.
std::string help_text(const ProgramText& program, std::size_t columns);
std::string help_text(const CommandText& command, std::size_t columns, bool all = false);

/// Returns the width of a help text: COLUMNS if it is a positive number, otherwise the width of the
/// terminal behind stdout, otherwise 80. The result is at least 40, and at most 100, because longer
/// lines are hard to read.
std::size_t help_columns();

/// Returns `text` in lines of at most `columns` characters, unless a word is longer. All lines but
/// the first begin with `indent` spaces: the caller has written the first `indent` columns of the
/// first line.
std::string wrapped(const std::string& text, std::size_t indent, std::size_t columns);

/// Returns the commands, options and examples of a program as JSON. `declare` declares them on a
/// new command line, and is called once more for each example. `program`: its name. `about`: one
/// line about the program. Throws RunError if the program does not understand one of its examples.
std::string describe(const std::function<void(CommandLine&)>& declare, const std::string& program,
                     const std::string& about);

/// Splits a command into words at spaces as a shell does, with '...' and "...". A # or & at the
/// beginning of a word ends the command. Backslashes have no special meaning.
std::vector<std::string> shell_words(const std::string& command);

}  // namespace parray::process
