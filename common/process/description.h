#pragma once

#include <cstdint>
#include <deque>
#include <string>
#include <vector>

#include "common/rooms.h"

/// A command line as data. --help and --describe (describe.h) print it; CommandLine fills it while
/// the options are declared.
namespace parray::process {

/// What a shell offers as a value, besides known words.
enum class Completes : std::uint8_t { nothing, files, directories, jobs, commands };

/// An option, or a positional argument.
struct OptionText {
  std::vector<std::string> names;  ///< "-o", "--output"; empty for an argument
  std::string value;  ///< placeholder of the value, or the argument's name; empty: a flag
  std::string text;
  std::string heading = "Options";
  std::string default_value{};       ///< empty: no default, or `text` states it
  std::string environment{};         ///< variable that replaces a missing option; empty: none
  std::string with{};                ///< option that it requires; empty: none
  std::vector<std::string> words{};  ///< known values
  bool list = false;                 ///< several words, separated by commas
  Completes completes = Completes::nothing;
  bool required = false;
  bool repeats = false;
  bool special = false;  ///< for experiments: only `help COMMAND --all` shows it

  [[nodiscard]] bool is_argument() const { return names.empty(); }
  /// "-o, --output IMAGE".
  [[nodiscard]] std::string shown() const;
};

/// A command to copy. The build fails if its program does not understand it.
struct Example {
  std::string command;
  std::string about;
};

/// A command with its options. For a program, `options` are those without a command.
struct CommandText {
  std::string name;                ///< "parray render"
  std::string heading;             ///< heading in the list of commands
  std::string about;               ///< one line
  std::string launcher;            ///< before the name: "mpirun -n P "
  std::deque<OptionText> options;  ///< options and arguments, in order of declaration
  std::vector<Example> examples;

  /// "render" of "parray render".
  [[nodiscard]] std::string word() const { return name.substr(name.rfind(' ') + 1); }
  /// "parray render SCENE -o IMAGE [OPTION...]".
  [[nodiscard]] std::string usage(bool has_commands) const;
  /// The name of its man page: "parray-render".
  [[nodiscard]] std::string page() const;
  /// Returns the headings of its options, in order of first use.
  [[nodiscard]] std::vector<std::string> headings() const;
};

struct ProgramText {
  CommandText self;
  std::deque<CommandText> commands;

  /// Returns the headings of its commands.
  [[nodiscard]] std::vector<std::string> headings() const;
};

/// The exit statuses of every program.
inline constexpr const char* exit_statuses =
    "0 done; 1 failed; 2 bad usage or bad input; 130 interrupted";

}  // namespace parray::process
