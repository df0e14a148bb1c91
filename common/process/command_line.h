#pragma once

#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <type_traits>
#include <vector>

#include "common/base/error.h"
#include "common/process/description.h"

namespace CLI {  // NOLINT(readability-identifier-naming): its own name
class App;
class Option;
}  // namespace CLI

/// The parts of CLI11 that programs need. Only command_line.cpp includes its headers, because they
/// compile slowly. The target of an option is the variable that receives its value. Targets must
/// not move until the command line is parsed.
namespace parray::process {

/// Does the work of a program or a command and returns the exit status. Throws InputError, RunError
/// or Interrupted.
using Action = std::function<int()>;

/// The command line cannot be understood.
class UsageError : public InputError {
 public:
  using InputError::InputError;
};

/// An option or a positional argument. Every call returns the same option. An Option and a Command
/// refer to their CommandLine, which must outlive them.
class Option {
 public:
  Option() = default;
  Option(CLI::Option* option, OptionText* text) : option_(option), text_(text) {}

  Option& required(bool is_required = true);
  /// Sets the placeholder of the value in the help.
  Option& type_name(const std::string& name);
  /// Sets the heading in the help.
  Option& group(const std::string& name);
  /// Makes the help show the current value of the target as the default.
  Option& show_default();
  /// Sets the name of an environment variable that gives the value if the option is missing.
  Option& environment(const std::string& name);
  /// Makes a second use of this option an error. Otherwise the last use counts.
  Option& only_once();
  /// Reads the value when the parser meets the option, so that it can depend on the options before
  /// it. Other options are read when the whole command line is parsed.
  Option& in_order();
  /// Allows several uses, with one value each.
  Option& one_value_each();
  /// Refuses an empty value, which would read as "not given".
  Option& forbid_empty();
  /// Refuses values that are not in `known`.
  Option& one_of(const std::vector<std::string>& known);
  /// Lists known words for the help and shells; the reader of the value refuses others. `list`:
  /// several words, separated by commas.
  Option& words(const std::vector<std::string>& words, bool list = false);
  /// Sets what a shell offers as values besides known words.
  Option& completes(Completes what);
  /// Marks a command's option as rarely needed: only `help COMMAND --all` and the man page show it.
  Option& special();
  /// Makes it an error to give this option without the option `other`. A value from the environment
  /// variable of this option is no error; for that, call environment() first.
  Option& needs(const Option& other);
  /// Makes it an error to give this option together with the option `other`.
  Option& excludes(const Option& other);

 private:
  CLI::Option* option_ = nullptr;
  OptionText* text_ = nullptr;
};

/// An option from the command line.
struct GivenOption {
  std::string name;   ///< the first long name: "--output"
  std::string group;  ///< heading in the help
  std::string value;  ///< empty for a flag
};

/// A command with its options, such as `parray render`.
class Command {
 public:
  /// `chosen`: where parse() keeps the action of the command that the user names.
  Command(CLI::App* app, CommandText* text, Action* chosen)
      : app_(app), text_(text), chosen_(chosen) {}

  /// Declares an option. `names` has CLI11's form: "-o,--output", or "SCENE" for an argument.
  /// `description`: its text in the help. Parsing writes the given value to `target`; a missing
  /// option leaves `target` as it is.
  Option option(const std::string& names, std::string& target, const std::string& description);
  /// Collects all given values.
  Option option(const std::string& names, std::vector<std::string>& target,
                const std::string& description);
  /// Calls `set` with the text of the user. An InputError of `set` becomes a UsageError that names
  /// the option. Of several uses the last counts.
  Option option(const std::string& names, std::function<void(const std::string&)> set,
                const std::string& description);
  /// Declares an option with a number from `least` to `most`, in CLI11's format. `Number`: int,
  /// std::size_t or double.
  template <typename Number>
  Option number(const std::string& names, Number& target, std::type_identity_t<Number> least,
                std::type_identity_t<Number> most, const std::string& description);
  /// Declares an option without a value, which sets `target` to true.
  Option flag(const std::string& names, bool& target, const std::string& description);
  /// Declares an option with the values on and off. The target of a missing option stays empty.
  Option on_off(const std::string& name, std::optional<bool>& target,
                const std::string& description);
  /// Makes an old option an error that names its replacement `now`, such as "--labels off".
  void renamed(const std::string& old, const std::string& now);

  /// Sets the heading of the options that are declared later, and the option that they require.
  void section(const std::string& heading, std::optional<Option> required = {});

  /// Adds a shell command that users can copy, and what it does. --describe, and with it the build,
  /// fails if the program does not understand the command.
  void example(const std::string& command, const std::string& about);

  /// Sets what CommandLine::chosen() returns if the user names this command.
  void runs(Action action);
  /// Returns the options that the command line gives; values of environment variables do not count.
  /// First come those without in_order(), once each, with the last value. Then come the others in
  /// their order, as often as they are given.
  [[nodiscard]] std::vector<GivenOption> given_options() const;

 protected:
  Option added(CLI::Option* option, const std::string& names, const std::string& value,
               const std::string& description);

  CLI::App* app_;
  CommandText* text_;

 private:
  Action* chosen_;
  std::string section_;
  std::optional<Option> section_needs_;
  using Values = std::shared_ptr<std::vector<std::string>>;
  /// The values with which the functions of options were called.
  std::shared_ptr<std::map<const CLI::Option*, Values>> called_with_ =
      std::make_shared<std::map<const CLI::Option*, Values>>();
};

/// A whole command line.
class CommandLine : public Command {
 public:
  /// `program`: the name in the usage and in messages.
  explicit CommandLine(const std::string& description = {}, const std::string& program = {});
  ~CommandLine();
  CommandLine& operator=(CommandLine&&) = delete;

  /// Sets the text of --version.
  void version(const std::string& text);
  /// Sets the words before the program's name: "mpirun -n P ".
  void launcher(const std::string& words) { text_->launcher = words; }
  /// Sets the heading of commands that are declared later.
  void heading(const std::string& name) { heading_ = name; }
  /// Declares a command of the program. `description`: its line in the help.
  Command command(const std::string& name, const std::string& description);
  /// Adds the command help [COMMAND], which prints the same as --help.
  void add_help_command();
  /// Returns the output of --help of the program: see description.h.
  [[nodiscard]] std::string help() const;
  /// Returns everything declared so far, with --help added to the program and each command.
  [[nodiscard]] ProgramText description() const;

  /// Parses the arguments of main(), which begin with the program. Returns the text to print for
  /// --help, --version and the command help, otherwise nothing. Throws UsageError: one line that
  /// names the problem, the option, the most similar known option, and the help to read.
  std::optional<std::string> parse(int argc, const char* const* argv);
  /// Parses options without the program's name, written as in a shell. Throws UsageError.
  void parse(const std::string& words);

  /// Returns the action of the command that the user named; empty if the user named none.
  [[nodiscard]] const Action& chosen() const { return chosen_action_; }

 private:
  [[nodiscard]] std::string help_of(const std::string& name) const;
  void check_needs() const;

  std::unique_ptr<CLI::App> root_;
  ProgramText program_;
  Action chosen_action_;
  std::string heading_ = "Commands";
  std::string topic_;         ///< COMMAND of the help command
  bool all_options_ = false;  ///< --all of the help command
};

}  // namespace parray::process
