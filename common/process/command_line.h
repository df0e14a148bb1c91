#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "common/base/error.h"

namespace CLI {
class App;
class Option;
}  // namespace CLI

/// What programs need of CLI11, without its headers, which take longer to compile than most of our
/// sources: command_line.cpp alone includes them. What an option refers to must stay where it is
/// while the command line is parsed.
namespace parray {

/// The command line cannot be understood.
class UsageError : public InputError {
 public:
  using InputError::InputError;
};

/// An option, or an argument that has a place instead of a name. Every call returns the same
/// option.
class Option {
 public:
  explicit Option(CLI::Option* option) : option_(option) {}

  Option& required(bool is_required = true);
  /// What the help shows in the place of the value.
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
  Option& one_of(const std::vector<std::string>& words);
  /// Makes sense only beside `other`.
  Option& needs(const Option& other);

 private:
  CLI::Option* option_;
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
  explicit Command(CLI::App* app) : app_(app) {}

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

  /// `chosen` is called once the user has been understood to want this command.
  void on_chosen(std::function<void()> chosen);
  [[nodiscard]] std::vector<GivenOption> given_options() const;

 protected:
  CLI::App* app_;
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
  /// The end of the help.
  void footer(const std::string& text);
  Command command(const std::string& name, const std::string& description);
  [[nodiscard]] std::string help() const;

  /// What is to be printed where the user has only asked for that: --help, --version. Throws
  /// UsageError: one line that says what is wrong, names the option, the nearest known one if it is
  /// unknown, and the help to read.
  std::optional<std::string> parse(int argc, const char* const* argv);
  /// Options alone, as in a shell. Throws UsageError.
  void parse(const std::string& words);

 private:
  std::unique_ptr<CLI::App> root_;
};

}  // namespace parray
