#include "common/process/manual_page.h"

#include <algorithm>
#include <cctype>
#include <sstream>
#include <string_view>

namespace parray::process {
namespace {

/// Escapes plain text so that it is safe everywhere except at the beginning of a line.
std::string escaped(std::string_view text) {
  std::string out;
  for (const char c : text) {
    switch (c) {
      case '\\':
        out += "\\e";
        break;
      case '-':
        out += "\\-";
        break;
      case '\'':
        out += "\\(aq";
        break;
      case '`':
        out += "\\(ga";
        break;
      case '^':
        out += "\\(ha";
        break;
      case '~':
        out += "\\(ti";
        break;
      case '"':
        out += "\\(dq";
        break;
      default:
        out += c;
    }
  }
  return out;
}

std::string bold(std::string_view text) { return "\\fB" + escaped(text) + "\\fR"; }

/// Returns a line of text; words in backticks become literal.
std::string text_line(std::string_view text) {
  std::string out = text.starts_with(".") ? "\\&" : "";
  bool literal = false;
  for (std::size_t begin = 0; begin <= text.size(); literal = !literal) {
    const std::size_t end = std::min(text.find('`', begin), text.size());
    const std::string_view part = text.substr(begin, end - begin);
    if (!part.empty()) out += literal ? bold(part) : escaped(part);
    begin = end + 1;
  }
  return out + "\n";
}

std::string section(const std::string& name) { return ".SH \"" + escaped(name) + "\"\n"; }

std::string upper(std::string text) {
  std::ranges::transform(text, text.begin(), [](unsigned char c) { return std::toupper(c); });
  return text;
}

std::string page_of(const std::string& name) { return bold(name) + "(1)"; }

/// Converts the form of `manual` to macros.
class ManualText {
 public:
  std::string macros(const std::string& manual) {
    std::istringstream lines(manual);
    for (std::string line; std::getline(lines, line);) take(line);
    close();
    return out_;
  }

 private:
  void take(const std::string& line) {
    if (line.starts_with("    ")) {
      if (!literal_) out_ += paragraph_ ? ".IP\n.EX\n" : ".PP\n.RS 4\n.EX\n";
      in_list_ = paragraph_;
      literal_ = true;
      out_ += "\\&" + escaped(line.substr(4)) + "\n";
      return;
    }
    if (line.empty()) {
      empty_ = true;
      return;
    }
    close();
    if (line.starts_with("# ")) {
      out_ += section(upper(line.substr(2)));
      paragraph_ = empty_ = false;
    } else if (line.starts_with("- ")) {
      out_ += ".IP \\(bu 2\n" + text_line(line.substr(2));
      paragraph_ = true;
      empty_ = false;
    } else {
      const bool continues = paragraph_ && line.starts_with("  ");
      if (empty_ && !continues) out_ += ".PP\n";
      if (empty_ && continues) out_ += ".IP\n";
      if (!continues) paragraph_ = false;
      empty_ = false;
      out_ += text_line(line.substr(continues ? 2 : 0));
    }
  }

  void close() {
    if (literal_) out_ += in_list_ ? ".EE\n" : ".EE\n.RE\n";
    literal_ = false;
  }

  std::string out_;
  bool literal_ = false;    ///< in an indented block
  bool in_list_ = false;    ///< in text that belongs to a point of a list
  bool paragraph_ = false;  ///< in a point of a list
  bool empty_ = false;      ///< the previous line was empty
};

/// Returns ".TP", the option and its description.
std::string option_entry(const OptionText& option) {
  std::string names;
  for (const std::string& name : option.names) names += (names.empty() ? "" : ", ") + bold(name);
  const std::string value = "\\fI" + escaped(option.value) + "\\fR";
  std::string entry = ".TP\n" + names;
  if (!option.value.empty()) entry += (names.empty() ? "" : " ") + value;
  entry += "\n" + text_line(option.text + ".");
  if (!option.default_value.empty()) entry += "Default: " + bold(option.default_value) + ".\n";
  if (!option.environment.empty()) {
    entry += "The environment variable " + bold(option.environment) + " says the same.\n";
  }
  if (!option.with.empty()) entry += "Only with " + bold(option.with) + ".\n";
  return entry;
}

std::string options_sections(const CommandText& command) {
  std::string arguments;
  for (const OptionText& option : command.options) {
    if (option.is_argument()) arguments += option_entry(option);
  }
  std::string text = arguments.empty() ? "" : section("ARGUMENTS") + arguments;
  text += section("OPTIONS");
  for (const std::string& heading : command.headings()) {
    text += ".SS \"" + escaped(heading) + "\"\n";
    for (const OptionText& option : command.options) {
      if (option.heading == heading && !option.is_argument()) text += option_entry(option);
    }
  }
  return text;
}

std::string head(const CommandText& command, const std::string& usage) {
  const std::string page = command.page();
  std::string about = command.about;
  about.front() = static_cast<char>(std::tolower(static_cast<unsigned char>(about.front())));
  return ".\\\" Made by " + command.name.substr(0, command.name.find(' ')) +
         " --describe.\n.TH \"" + escaped(upper(page)) +
         "\" 1 \"\" \"ParRay " PARRAY_VERSION "\" \"ParRay\"\n.nh\n.ad l\n" + section("NAME") +
         escaped(page) + " \\- " + escaped(about) + "\n" + section("SYNOPSIS") +
         text_line("`" + usage + "`");
}

std::string description(const CommandText& command) {
  return section("DESCRIPTION") + text_line(command.about + ".") +
         (command.manual.empty() ? "" : ".PP\n" + ManualText().macros(command.manual));
}

std::string examples(const CommandText& command) {
  if (command.examples.empty()) return "";
  std::string text = section("EXAMPLES");
  for (const Example& example : command.examples) {
    std::string about = example.about;
    about.front() = static_cast<char>(std::toupper(static_cast<unsigned char>(about.front())));
    text += ".PP\n" + text_line(about + ":") + ".PP\n.RS 4\n.EX\n\\&" + escaped(example.command) +
            "\n.EE\n.RE\n";
  }
  return text;
}

std::string environment(const CommandText& command) {
  std::string text;
  for (const OptionText& option : command.options) {
    if (option.environment.empty()) continue;
    text += ".TP\n" + bold(option.environment) + "\nWhat " + bold(option.names.front()) +
            " is where it is not given.\n";
  }
  return text.empty() ? "" : section("ENVIRONMENT") + text;
}

std::string exit_status() {
  std::string statuses = exit_statuses;
  statuses += '.';
  return section("EXIT STATUS") + text_line(statuses);
}

}  // namespace

std::string manual_page(const ProgramText& program, const CommandText& command) {
  std::string see;
  for (const CommandText& other : program.commands) {
    if (other.heading == command.heading && other.name != command.name) {
      see += ", " + page_of(other.page());
    }
  }
  return head(command, command.usage(false)) + description(command) + options_sections(command) +
         examples(command) + environment(command) + exit_status() + section("SEE ALSO") +
         page_of(program.self.page()) + see + "\n";
}

std::string manual_page(const ProgramText& program) {
  const CommandText& self = program.self;
  std::string commands;
  for (const std::string& heading : program.headings()) {
    commands += ".SS \"" + escaped(heading) + "\"\n";
    for (const CommandText& command : program.commands) {
      if (command.heading == heading) {
        commands += ".TP\n" + page_of(command.page()) + "\n" + text_line(command.about + ".");
      }
    }
  }
  std::string see;
  for (const char* other : {"parray", "parray-coordinator", "parray-worker", "parray-mpi"}) {
    if (self.name != other) see += (see.empty() ? "" : ", ") + page_of(other);
  }
  return head(self, self.usage(!program.commands.empty())) + description(self) +
         (commands.empty() ? "" : section("COMMANDS") + commands) + options_sections(self) +
         examples(self) + environment(self) + exit_status() + section("SEE ALSO") + see + "\n";
}

}  // namespace parray::process
