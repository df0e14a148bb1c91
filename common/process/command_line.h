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

/// What programs need of CLI11, without its headers, which take longer to compile than most of our
/// sources: command_line.cpp alone includes them. What an option refers to must stay where it is
/// while the command line is parsed.
namespace parray::process {

/// The command line cannot be understood.
class UsageError : public InputError {
 public:
  using InputError::InputError;
};

/// An option, or an argument that has a place instead of a name. Every call returns the same
/// option.
class Option {
 public:
  Option() = default;
  Option(CLI::Option* option, OptionText* text) : option_(option), text_(text) {}

  Option& required(bool is_required = true);
  /// What stands for the value in the help.
  Option& type_name(const std::string& name);
  /// The heading of the help that it stands under.
  Option& group(const std::string& name);
  /// The help shows what the target holds now.
  Option& show_default();
  /// An environment variable that counts where the option is not given.
  Option& environment(const std::string& name);
  /// Given twice is an error.
  Option& only_once();
  /// May be given several times, with one value each.
  Option& one_value_each();
  /// Refuses an empty value, which would read as "not given".
  Option& forbid_empty();
  /// Refuses any other.
  Option& one_of(const std::vector<std::string>& known);
  /// Known words, for help and shells; whoever reads the value refuses others. `list`: several,
  /// with commas between.
  Option& words(const std::vector<std::string>& words, bool list = false);
  Option& completes(Completes what);
  /// For experiments: --help of a command leaves it out, `help COMMAND --all` shows it.
  Option& special();
  /// Makes sense only beside `other`.
  Option& needs(const Option& other);

 private:
  CLI::Option* option_ = nullptr;
  OptionText* text_ = nullptr;
};

/// An option that the user has given.
struct GivenOption {
  std::string name;
  std::string group;
  std::string value;  ///< the last
};

/// A command with its options: what `parray render` takes.
class Command {
 public:
  Command(CLI::App* app, CommandText* text) : app_(app), text_(text) {}

  // `names` as CLI11 has them: "-o,--output", or "SCENE" for an argument.
  Option option(const std::string& names, std::string& target, const std::string& description);
  /// All that are given.
  Option option(const std::string& names, std::vector<std::string>& target,
                const std::string& description);
  /// `set` gets the text as the user wrote it; the InputError that it throws becomes a UsageError
  /// that names the option. Given twice, the last counts.
  Option option(const std::string& names, std::function<void(const std::string&)> set,
                const std::string& description);
  /// A number from `least` to `most`, as CLI11 reads numbers.
  Option number(const std::string& names, int& target, int least, int most,
                const std::string& description);
  Option number(const std::string& names, std::size_t& target, std::size_t least, std::size_t most,
                const std::string& description);
  Option number(const std::string& names, double& target, double least, double most,
                const std::string& description);
  Option flag(const std::string& names, bool& target, const std::string& description);
  /// A switch with the values on and off. The target stays empty where it is not given.
  Option on_off(const std::string& name, std::optional<bool>& target,
                const std::string& description);
  /// A spelling of earlier versions: an error that names what to write `now`, as "--labels off".
  void renamed(const std::string& old, const std::string& now);

  /// A command to copy, and what it does. One that is not understood fails --describe, and with it
  /// the build.
  void example(const std::string& command, const std::string& about);

  /// `chosen` is called once the user has been understood to want this command.
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

  /// What --version prints.
  void version(const std::string& text);
  /// What starts the program: "mpirun -n P ".
  void launcher(const std::string& words);
  /// Commands that are declared from now on stand under this heading of the help.
  void heading(const std::string& name) { heading_ = name; }
  Command command(const std::string& name, const std::string& description);
  /// help [COMMAND]: prints what --help does.
  void add_help_command();
  [[nodiscard]] std::string help() const;
  [[nodiscard]] ProgramText description() const;

  /// What is to be printed where the user has only asked for that: --help, --version. Throws
  /// UsageError: one line that says what is wrong, names the option, the nearest known one if it is
  /// unknown, and the help to read.
  std::optional<std::string> parse(int argc, const char* const* argv);
  /// Options alone, as in a shell. Throws UsageError.
  void parse(const std::string& words);

 private:
  [[nodiscard]] std::string help_of(const std::string& name) const;

  std::unique_ptr<CLI::App> root_;
  ProgramText program_;
  std::string heading_ = "Commands";
  std::string topic_;         ///< of the help command
  bool all_options_ = false;  ///< likewise
};

}  // namespace parray::process
