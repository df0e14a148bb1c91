#include "common/process/description.h"

#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <nlohmann/json.hpp>
#include <sstream>
#include <utility>

#include "common/base/error.h"
#include "common/base/text.h"
#include "common/process/command_line.h"

namespace parray::process {
namespace {

constexpr std::size_t text_column = 26;

/// Returns an entry of the help: "  --width N             Pixels across".
std::string entry(const std::string& left, const std::string& text, std::size_t columns) {
  std::string line = "  " + left;
  if (line.size() + 2 > text_column) {
    line += "\n" + std::string(text_column, ' ');
  } else {
    line.resize(text_column, ' ');
  }
  return line + wrapped(text, text_column, columns) + "\n";
}

std::string notes(const OptionText& option) {
  std::string text = option.text;
  if (!option.default_value.empty()) text += " (default: " + option.default_value + ")";
  if (!option.environment.empty()) text += " (or $" + option.environment + ")";
  if (!option.with.empty()) text += " (with " + option.with + ")";
  return text;
}

/// Returns what `text_of` returns for each entry, below the entry's heading. Headings are in the
/// order of their first use; one without text is left out.
std::string under_headings(const auto& entries, const auto& text_of) {
  std::vector<std::pair<std::string, std::string>> sections;
  for (const auto& described : entries) {
    auto section =
        std::ranges::find(sections, described.heading, [](const auto& s) { return s.first; });
    if (section == sections.end()) section = sections.insert(section, {described.heading, ""});
    section->second += text_of(described);
  }
  std::string text;
  for (const auto& [heading, below] : sections) {
    if (!below.empty()) text += heading + ":\n" + below + "\n";
  }
  return text;
}

std::string options_text(const CommandText& command, std::size_t columns, bool all) {
  std::string text;
  std::vector<OptionText> named;
  for (const OptionText& option : command.options) {
    if (option.is_argument()) {
      text += entry(option.shown(), notes(option), columns);
    } else {
      named.push_back(option);
    }
  }
  if (!text.empty()) text += "\n";
  return text + under_headings(named, [&](const OptionText& option) {
           return option.special && !all ? "" : entry(option.shown(), notes(option), columns);
         });
}

std::string examples_text(const CommandText& command, std::size_t columns) {
  if (command.examples.empty()) return "";
  std::string text = "Examples:\n";
  for (const Example& example : command.examples) {
    text += "  " + example.command + "\n      " + wrapped(example.about, 6, columns) + "\n";
  }
  return text + "\n";
}

std::string head_text(const CommandText& command, bool has_commands, std::size_t columns) {
  return "Usage: " + wrapped(command.usage(has_commands), 7, columns) + "\n\n" +
         wrapped(command.about + ".", 0, columns) + "\n\n";
}

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

std::string OptionText::shown() const {
  return joined(names, ", ") + (names.empty() || value.empty() ? "" : " ") + value;
}

std::string CommandText::usage(bool has_commands) const {
  std::string text = launcher + name + (has_commands ? " COMMAND" : "");
  for (const OptionText& option : options) {
    if (!option.is_argument()) continue;
    const std::string shown = option.value + (option.repeats ? "..." : "");
    text += option.required ? " " + shown : " [" + shown + "]";
  }
  for (const OptionText& option : options) {
    if (!option.is_argument() && option.required) {
      text += " " + option.names.front() + " " + option.value;
    }
  }
  return text + (has_commands ? " [ARGUMENT...]" : " [OPTION...]");
}

std::string CommandText::page() const {
  std::string page = name;
  std::ranges::replace(page, ' ', '-');
  return page;
}

std::string wrapped(const std::string& text, std::size_t indent, std::size_t columns) {
  std::istringstream words(text);
  std::string lines;
  std::size_t length = indent;
  for (std::string word; words >> word;) {
    if (lines.empty()) {
      lines = word;
    } else if (length + 1 + word.size() > columns) {
      lines += "\n" + std::string(indent, ' ') + word;
      length = indent;
    } else {
      lines += " " + word;
      ++length;
    }
    length += word.size();
  }
  return lines;
}

std::string help_text(const CommandText& command, std::size_t columns, bool all) {
  const bool has_more = !all && std::ranges::any_of(command.options, &OptionText::special);
  const std::string word = command.word();
  const std::string program = command.name.substr(0, command.name.size() - word.size());
  return head_text(command, false, columns) + examples_text(command, columns) +
         options_text(command, columns, all) +
         wrapped((has_more ? "More options: " + program + "help " + word + " --all, man "
                           : "More: man ") +
                     command.page(),
                 0, columns) +
         "\n";
}

std::string help_text(const ProgramText& program, std::size_t columns) {
  const CommandText& self = program.self;
  if (program.commands.empty()) return help_text(self, columns, true);
  const auto line_of = [&](const CommandText& command) {
    return entry(command.word(), command.about, columns);
  };
  return head_text(self, true, columns) + under_headings(program.commands, line_of) +
         options_text(self, columns, true) + examples_text(self, columns) +
         wrapped("More: " + self.name + " help COMMAND, man " + self.page() +
                     ". Exit status: " + exit_statuses + ".",
                 0, columns) +
         "\n";
}

std::size_t help_columns() {
  // NOLINTNEXTLINE(concurrency-mt-unsafe): nothing changes the environment yet
  const char* const variable = std::getenv("COLUMNS");
  std::size_t columns = parsed<std::size_t>(variable == nullptr ? "" : variable).value_or(0);
  if (columns == 0) {
    winsize size{};
    const bool known = ioctl(STDOUT_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 0;
    columns = known ? size.ws_col : 80;
  }
  return std::clamp(columns, std::size_t{40}, std::size_t{100});
}

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
