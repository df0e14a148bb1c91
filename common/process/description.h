#pragma once

#include <cstdint>
#include <deque>
#include <string>
#include <vector>

#include "common/rooms.h"

/// A command line as data: what --help, man pages, completion and the JSON of --describe are made
/// of. CommandLine fills it while options are declared; see describe.h for what is made of it.
namespace parray::process {

/// What a shell offers in the place of a value, beside known words.
enum class Completes : std::uint8_t { nothing, files, directories, jobs, commands };

/// An option, or an argument that has a place instead of a name.
struct OptionText {
  std::vector<std::string> names;  ///< "-o", "--output"; of an argument empty
  std::string value;               ///< stands for the value; of an argument its name; empty: a flag
  std::string text;
  std::string heading = "Options";
  std::string default_value{};       ///< empty: none, or `text` says it
  std::string environment{};         ///< variable that counts where it is not given; empty: none
  std::string with{};                ///< option that it makes sense beside only; empty: none
  std::vector<std::string> words{};  ///< that the value may be
  bool list = false;                 ///< several words, with commas between
  Completes completes = Completes::nothing;
  bool required = false;
  bool repeats = false;
  bool special = false;  ///< for experiments: in the help of `help COMMAND --all` only

  [[nodiscard]] bool is_argument() const { return names.empty(); }
  /// "-o, --output IMAGE".
  [[nodiscard]] std::string shown() const;
};

/// A command that people can copy; one that its own program does not take fails the build.
struct Example {
  std::string command;
  std::string about;
};

/// A command with its options; of a program itself `options` are those without a command.
struct CommandText {
  std::string name;                ///< "parray render"
  std::string heading;             ///< that it stands under in the list of commands
  std::string about;               ///< one line
  std::string launcher;            ///< before the name: "mpirun -n P "
  std::deque<OptionText> options;  ///< arguments among them, in their order
  std::vector<Example> examples;

  /// "render" of "parray render".
  [[nodiscard]] std::string word() const { return name.substr(name.rfind(' ') + 1); }
  /// "parray render SCENE -o IMAGE [OPTION...]".
  [[nodiscard]] std::string usage(bool has_commands) const;
  /// The name of its man page: "parray-render".
  [[nodiscard]] std::string page() const;
  /// Of its options, in the order in which they first come up.
  [[nodiscard]] std::vector<std::string> headings() const;
};

struct ProgramText {
  CommandText self;
  std::deque<CommandText> commands;

  /// Of its commands.
  [[nodiscard]] std::vector<std::string> headings() const;
};

/// What every program's exit status means.
inline constexpr const char* exit_statuses =
    "0 done; 1 failed; 2 bad usage or bad input; 130 interrupted";

}  // namespace parray::process
