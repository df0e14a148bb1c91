#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "common/base/error.h"
#include "common/process/description.h"

namespace CLI {  // NOLINT(readability-identifier-naming): its own name
class App;
class Option;
}  // namespace CLI

/// The part of CLI11 that programs need, without its headers, which take longer to compile than
/// most of our sources: only command_line.cpp includes them. The target of an option must stay in
/// place while the command line is parsed.
namespace parray::process {

/// Thrown if the command line cannot be understood.
class UsageError : public InputError {
 public:
  using InputError::InputError;
};

/// An option, or a positional argument. Every function returns the same option.
class Option {
 public:
  Option() = default;
  Option(CLI::Option* option, OptionText* text) : option_(option), text_(text) {}

  Option& required(bool is_required = true);
  /// Sets the word that stands for the value in the help.
  Option& type_name(const std::string& name);
  /// Sets the heading of the help under which the option stands.
  Option& group(const std::string& name);
  /// Shows the present value of the target in the help.
  Option& show_default();
  /// Sets an environment variable that applies if the option is not given.
  Option& environment(const std::string& name);
  /// Makes it an error to give the option twice.
  Option& only_once();
  /// Allows the option several times, with one value each.
  Option& one_value_each();
  /// Refuses an empty value, which would read as "not given".
  Option& forbid_empty();
  /// Refuses all values outside `known`.
  Option& one_of(const std::vector<std::string>& known);
  /// Sets known words for the help and for shells. The code that reads the value refuses other
  /// words. `list`: the value is several words, separated by commas.
  Option& words(const std::vector<std::string>& words, bool list = false);
  Option& completes(Completes what);
  /// Marks the option as one for experiments: --help of a command leaves it out, `help COMMAND
  /// --all` shows it.
  Option& special();
  /// Makes the option valid only together with `other`.
  Option& needs(const Option& other);

 private:
  CLI::Option* option_ = nullptr;
  OptionText* text_ = nullptr;
};

/// An option that the user has given.
struct GivenOption {
  std::string name;
  std::string group;
  std::string value;  ///< the last value
};

/// A command with its options, such as `parray render`.
class Command {
 public:
  Command(CLI::App* app, CommandText* text) : app_(app), text_(text) {}

  // `names` as CLI11 has them: "-o,--output", or "SCENE" for an argument.
  Option option(const std::string& names, std::string& target, const std::string& description);
  /// Adds an option that collects all given values.
  Option option(const std::string& names, std::vector<std::string>& target,
                const std::string& description);
  /// Adds an option that calls `set` with the text as the user wrote it. An InputError from `set`
  /// becomes a UsageError that names the option. If the option is given twice, the last value
  /// counts.
  Option option(const std::string& names, std::function<void(const std::string&)> set,
                const std::string& description);
  /// Adds an option for a number from `least` to `most`, in CLI11's syntax of numbers.
  Option number(const std::string& names, int& target, int least, int most,
                const std::string& description);
  Option number(const std::string& names, std::size_t& target, std::size_t least, std::size_t most,
                const std::string& description);
  Option number(const std::string& names, double& target, double least, double most,
                const std::string& description);
  Option flag(const std::string& names, bool& target, const std::string& description);
  /// Adds a switch with the values on and off. The target stays empty if the switch is not given.
  Option on_off(const std::string& name, std::optional<bool>& target,
                const std::string& description);
  /// Adds the spelling of an earlier version. Its use is an error that names the present spelling
  /// `now`, such as "--labels off".
  void renamed(const std::string& old, const std::string& now);

  /// Adds an example: a command to copy, and its effect. An example that the program does not
  /// understand fails --describe, and with it the build.
  void example(const std::string& command, const std::string& about);
  /// Sets the text for the man page, in the form of manual_page.h.
  void manual(const std::string& text);

  /// Sets the function that is called when the user has chosen this command.
  void on_chosen(std::function<void()> chosen);
  [[nodiscard]] std::vector<GivenOption> given_options() const;

 protected:
  Option added(CLI::Option* option, const std::string& names, const std::string& value,
               const std::string& description);
  template <typename Number>
  Option add_number(const std::string& names, Number& target, Number least, Number most,
                    const std::string& description);

  CLI::App* app_;
  CommandText* text_;
};

/// A whole command line.
class CommandLine : public Command {
 public:
  explicit CommandLine(const std::string& description = {}, const std::string& program = {});
  ~CommandLine();
  CommandLine(const CommandLine&) = delete;
  CommandLine& operator=(const CommandLine&) = delete;

  /// Sets the output of --version.
  void version(const std::string& text);
  /// Sets the words that start the program: "mpirun -n P ".
  void launcher(const std::string& words);
  /// Sets the heading of the help for the commands declared from now on.
  void heading(const std::string& name) { heading_ = name; }
  Command command(const std::string& name, const std::string& description);
  /// Sets the manual text of the program and of every command: `manual_of` of their last words.
  void add_manuals(const std::function<std::string(const std::string&)>& manual_of);
  /// Adds the command help [COMMAND], which prints the same as --help.
  void add_help_command();
  [[nodiscard]] std::string help() const;
  [[nodiscard]] ProgramText description() const;

  /// Parses the command line. If the user only asked for information (--help, --version), returns
  /// the text to print. Throws UsageError. Its one line says what is wrong, names the option, for
  /// an unknown option the nearest known one, and the help to read.
  std::optional<std::string> parse(int argc, const char* const* argv);
  /// Parses options alone, as in a shell. Throws UsageError.
  void parse(const std::string& words);

 private:
  [[nodiscard]] std::string help_of(const std::string& name) const;

  std::unique_ptr<CLI::App> root_;
  ProgramText program_;
  std::string heading_ = "Commands";
  std::string topic_;         ///< command named after `help`
  bool all_options_ = false;  ///< --all is given with `help`
};

}  // namespace parray::process
