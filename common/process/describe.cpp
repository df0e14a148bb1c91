#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>
#include <utility>

#include "common/base/error.h"
#include "common/process/command_line.h"

namespace parray::process {
namespace {

using nlohmann::ordered_json;

ordered_json json_of(const OptionText& option) {
  constexpr std::array kinds = {"nothing", "files", "directories", "jobs", "commands"};
  return {{"names", option.names},
          {"value", option.value},
          {"text", option.text},
          {"heading", option.heading},
          {"default", option.default_value},
          {"environment", option.environment},
          {"with", option.with},
          {"words", option.words},
          {"list", option.list},
          {"completes", kinds.at(static_cast<std::size_t>(option.completes))},
          {"required", option.required},
          {"special", option.special},
          {"repeats", option.repeats}};
}

ordered_json json_of(const CommandText& command, bool has_commands = false) {
  ordered_json options = ordered_json::array();
  for (const OptionText& option : command.options) options.push_back(json_of(option));
  ordered_json examples = ordered_json::array();
  for (const Example& example : command.examples) {
    examples.push_back({{"command", example.command}, {"about", example.about}});
  }
  return {{"name", command.name},
          {"page", command.page()},
          {"usage", command.usage(has_commands)},
          {"heading", command.heading},
          {"about", command.about},
          {"options", options},
          {"examples", examples}};
}

ordered_json json_of(const ProgramText& program) {
  ordered_json description = json_of(program.self, !program.commands.empty());
  description["version"] = PARRAY_VERSION;
  description["exit_statuses"] = exit_statuses;
  description["commands"] = ordered_json::array();
  for (const CommandText& command : program.commands) {
    description["commands"].push_back(json_of(command));
  }
  return description;
}

}  // namespace

std::vector<std::string> shell_words(const std::string& command) {
  std::vector<std::string> words;
  std::string word;
  bool in_word = false;
  char quote = 0;
  const auto end_word = [&] {
    if (in_word) words.push_back(std::exchange(word, {}));
    in_word = false;
  };
  for (const char c : command) {
    if (quote != 0 && c == quote) {
      quote = 0;
    } else if (quote != 0) {
      word += c;
    } else if (c == '\'' || c == '"') {
      quote = c;
      in_word = true;
    } else if (c == ' ') {
      end_word();
    } else if (!in_word && (c == '#' || c == '&')) {
      return words;
    } else {
      word += c;
      in_word = true;
    }
  }
  end_word();
  return words;
}

std::string describe(const std::function<void(CommandLine&)>& declare, const std::string& program,
                     const std::string& about) {
  const auto check = [&](const CommandText& command) {
    for (const Example& example : command.examples) {
      const std::vector<std::string> words = shell_words(example.command);
      const auto begin = std::ranges::find(words, program);
      std::vector<const char*> arguments;
      for (auto word = begin; word != words.end(); ++word) arguments.push_back(word->c_str());
      CommandLine line(about, program);
      declare(line);
      try {
        if (arguments.empty()) throw UsageError("it does not name " + program);
        line.parse(static_cast<int>(arguments.size()), arguments.data());
      } catch (const UsageError& error) {
        throw RunError("the example '" + example.command + "': " + error.what());
      }
    }
  };
  CommandLine line(about, program);
  declare(line);
  const ProgramText description = line.description();
  check(description.self);
  std::ranges::for_each(description.commands, check);
  return json_of(description).dump(1) + "\n";
}

}  // namespace parray::process
