#pragma once

#include <cstdint>
#include <deque>
#include <string>
#include <vector>

#include "common/rooms.h"

/// A command line as data: the source of --help, man pages, completion and the JSON of --describe.
/// CommandLine fills it while options are declared; describe.h lists the outputs.
namespace parray::process {

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
  /// Returns the headings of its options in the order of their first use.
  [[nodiscard]] std::vector<std::string> headings() const;
};

/// A program with its commands.
struct ProgramText {
  CommandText self;  ///< the program itself, with the options that need no command
  std::deque<CommandText> commands;

  /// Returns the headings of its commands in the order of their first use.
  [[nodiscard]] std::vector<std::string> headings() const;
};

/// The meaning of every program's exit status.
inline constexpr const char* exit_statuses =
    "0 done; 1 failed; 2 bad usage or bad input; 130 interrupted";

}  // namespace parray::process
