#include "common/process/completion.h"

#include <algorithm>
#include <set>
#include <utility>

namespace parray::process {
namespace {

/// A command that prints the numbers of the coordinator's jobs, one per line, or nothing if the
/// coordinator does not answer at once.
constexpr const char* list_jobs = "timeout 1 parray jobs 2>/dev/null | awk 'NR > 1 {print $1}'";

std::string joined(const std::vector<std::string>& words) {
  std::string text;
  for (const std::string& word : words) text += (text.empty() ? "" : " ") + word;
  return text;
}

std::string command_words(const ProgramText& program) {
  std::vector<std::string> words;
  for (const CommandText& command : program.commands) words.push_back(command.word());
  return joined(words);
}

std::string function_name(const ProgramText& program) {
  std::string name = "_" + program.self.name;
  std::ranges::replace(name, '-', '_');
  return name;
}

std::string header(const ProgramText& program, const std::string& shell) {
  return "# " + shell + " completion of " + program.self.name + ", made by `" + program.self.name +
         " --describe`.\n";
}

std::string replaced(std::string text, const std::string& what, const std::string& by) {
  for (std::size_t at = text.find(what); at != std::string::npos;
       at = text.find(what, at + by.size())) {
    text.replace(at, what.size(), by);
  }
  return text;
}

/// Returns the text in single quotes, in the syntax of these shells.
std::string quoted(const std::string& text) { return "'" + replaced(text, "'", "'\\''") + "'"; }

// ---- bash ------------------------------------------------------------------------------------

/// A template with parts to insert between @.
constexpr const char* bash_template = R"bash(@FUNCTION@() {
  local cur=${COMP_WORDS[COMP_CWORD]} command='' option='' kind=nothing flags='' before i at=0
  local -a arguments=()
  local valued=' @VALUED@ '
  COMPREPLY=()
  # Bash makes = a word of its own: "--adaptive=on" is three.
  for ((i = 1; i < COMP_CWORD; ++i)); do
    if [[ ${COMP_WORDS[i]} == -* ]]; then
      [[ $valued == *" ${COMP_WORDS[i]} "* ]] || continue
      option=${COMP_WORDS[i]}
      [[ ${COMP_WORDS[i + 1]} == = ]] && ((++i))
      ((++i < COMP_CWORD)) && option=''
@TAKE_COMMAND@    else
      ((++at))
    fi
  done
  [[ $cur == = ]] && cur=''
  case $command in
@CASES@  esac
  if [[ -z $option ]]; then
    if [[ $cur == -* ]]; then
      kind="words $flags"
@OFFER_COMMANDS@    else
      kind=${arguments[at]-nothing}
    fi
  fi
  case $kind in
    words*) mapfile -t COMPREPLY < <(compgen -W "${kind#words }" -- "$cur") ;;
    list*)
      before=${cur%"${cur##*,}"}
      mapfile -t COMPREPLY < <(compgen -P "$before" -W "${kind#list }" -- "${cur##*,}")
      compopt -o nospace
      ;;
    files)
      compopt -o filenames
      mapfile -t COMPREPLY < <(compgen -f -- "$cur")
      ;;
    directories)
      compopt -o filenames
      mapfile -t COMPREPLY < <(compgen -d -- "$cur")
      ;;
    jobs) mapfile -t COMPREPLY < <(compgen -W "$(@JOBS@)" -- "$cur") ;;
  esac
}
complete -F @FUNCTION@ @PROGRAM@
)bash";

constexpr const char* bash_take_command =
    "    elif [[ -z $command ]]; then\n      command=${COMP_WORDS[i]}\n";

/// Returns the word that tells the function which candidates to offer for a value.
std::string bash_kind(const ProgramText& program, const OptionText& option) {
  const std::string words = joined(option.words);
  if (!option.words.empty()) return quoted((option.list ? "list " : "words ") + words);
  switch (option.completes) {
    case Completes::files:
      return "files";
    case Completes::directories:
      return "directories";
    case Completes::jobs:
      return "jobs";
    case Completes::commands:
      return quoted("words " + command_words(program));
    case Completes::nothing:
      break;
  }
  return "nothing";
}

std::string bash_case(const ProgramText& program, const CommandText& command,
                      const std::string& word) {
  std::vector<std::string> flags;
  std::string arguments;
  std::string values;
  for (const OptionText& option : command.options) {
    flags.insert(flags.end(), option.names.begin(), option.names.end());
    const std::string kind = bash_kind(program, option);
    if (option.is_argument()) {
      arguments += (arguments.empty() ? "" : " ") + kind;
      if (option.repeats) arguments += " " + kind + " " + kind + " " + kind;
    } else if (!option.value.empty() && kind != "nothing") {
      std::string pattern;
      for (const std::string& name : option.names) pattern += (pattern.empty() ? "" : "|") + name;
      values += "        " + pattern + ") kind=" + kind + " ;;\n";
    }
  }
  return "    " + (word.empty() ? "''" : word) + ")\n      flags=" + quoted(joined(flags)) +
         " arguments=(" + arguments + ")\n" +
         (values.empty() ? "" : "      case $option in\n" + values + "      esac\n") + "      ;;\n";
}

/// Returns the options of all commands that take a value: a name means the same in all of them.
std::string valued_options(const ProgramText& program) {
  std::set<std::string> names;
  const auto collect = [&](const CommandText& command) {
    for (const OptionText& option : command.options) {
      if (!option.value.empty()) names.insert(option.names.begin(), option.names.end());
    }
  };
  collect(program.self);
  std::ranges::for_each(program.commands, collect);
  return joined({names.begin(), names.end()});
}

// ---- zsh -------------------------------------------------------------------------------------

std::string zsh_action(const OptionText& option) {
  if (option.list) return "_values -s , word " + joined(option.words);
  if (!option.words.empty()) return "(" + joined(option.words) + ")";
  switch (option.completes) {
    case Completes::files:
      return "_files";
    case Completes::directories:
      return "_directories";
    case Completes::jobs:
      return "->jobs";
    case Completes::commands:
      return "->commands";
    case Completes::nothing:
      break;
  }
  return " ";
}

std::string zsh_text(const std::string& text) {
  std::string out = replaced(text, "\\", "\\\\");
  for (const char* special : {"[", "]", ":"}) {
    out = replaced(out, special, std::string("\\") + special);
  }
  return out;
}

/// Returns a line of _arguments for each option.
std::string zsh_specs(const CommandText& command) {
  std::string lines;
  for (const OptionText& option : command.options) {
    const std::string value =
        option.value.empty() ? "" : ":" + zsh_text(option.value) + ":" + zsh_action(option);
    if (option.is_argument()) {
      const std::string place = option.repeats ? "*" : option.required ? "" : ":";
      lines += " \\\n        " + quoted(place + value);
      continue;
    }
    const std::string rest = "[" + zsh_text(option.text) + "]" + value;
    for (const std::string& name : option.names) {
      const bool is_long = name.starts_with("--");
      const std::string joint = option.value.empty() ? "" : is_long ? "=" : "+";
      const std::string before = option.repeats ? "*" : "(" + joined(option.names) + ")";
      lines += " \\\n        " + quoted(before + name + joint + rest);
    }
  }
  return lines;
}

// ---- fish ------------------------------------------------------------------------------------

/// Returns the arguments of `complete` with the candidates for a value; empty: none.
std::string fish_candidates(const ProgramText& program, const OptionText& option) {
  if (option.list) return " -a " + quoted("(__fish_append , " + joined(option.words) + ")");
  if (!option.words.empty()) return " -a " + quoted(joined(option.words));
  switch (option.completes) {
    case Completes::files:
      return " -F";
    case Completes::directories:
      return " -a '(__fish_complete_directories)'";
    case Completes::jobs:
      return " -a " + quoted("(" + std::string(list_jobs) + ")");
    case Completes::commands:
      return " -a " + quoted(command_words(program));
    case Completes::nothing:
      break;
  }
  return {};
}

std::string fish_lines(const ProgramText& program, const CommandText& command) {
  const bool is_program = &command == &program.self;
  const std::string condition = program.commands.empty() ? ""
                                : is_program
                                    ? " -n __fish_use_subcommand"
                                    : " -n '__fish_seen_subcommand_from " + command.word() + "'";
  std::string lines;
  for (const OptionText& option : command.options) {
    const std::string candidates = fish_candidates(program, option);
    if (option.is_argument() && candidates.empty()) continue;
    lines += "complete -c " + program.self.name + condition;
    for (const std::string& name : option.names) {
      lines += name.starts_with("--") ? " -l " + name.substr(2) : " -s " + name.substr(1);
    }
    if (!option.value.empty() && !option.is_argument()) {
      lines += option.completes == Completes::files ? " -r" : " -x";
    }
    lines += candidates + " -d " + quoted(option.text) + "\n";
  }
  return lines;
}

}  // namespace

std::string bash_completion(const ProgramText& program) {
  std::string cases = bash_case(program, program.self, "");
  for (const CommandText& command : program.commands) {
    cases += bash_case(program, command, command.word());
  }
  const bool commands = !program.commands.empty();
  std::string text = bash_template;
  const std::pair<const char*, std::string> parts[] = {
      {"@FUNCTION@", function_name(program)},
      {"@PROGRAM@", program.self.name},
      {"@VALUED@", valued_options(program)},
      {"@CASES@", cases},
      {"@TAKE_COMMAND@", commands ? bash_take_command : ""},
      {"@OFFER_COMMANDS@", commands ? "    elif [[ -z $command ]]; then\n      kind='words " +
                                          command_words(program) + "'\n"
                                    : ""},
      {"@JOBS@", list_jobs}};
  for (const auto& [name, part] : parts) text = replaced(text, name, part);
  return header(program, "bash") + text;
}

std::string zsh_completion(const ProgramText& program) {
  const std::string function = function_name(program);
  std::string text = "#compdef " + program.self.name + "\n" + header(program, "zsh") + function +
                     "() {\n  local context state state_descr line\n  typeset -A opt_args\n";
  if (program.commands.empty()) {
    text += "  _arguments -s" + zsh_specs(program.self) + "\n";
  } else {
    text += "  local -a commands=(\n";
    for (const CommandText& command : program.commands) {
      text += "    " + quoted(command.word() + ":" + command.about) + "\n";
    }
    text += "  )\n  _arguments -C" + zsh_specs(program.self) +
            " \\\n        '1:command:->commands' '*::argument:->argument'\n"
            "  if [[ $state == argument ]]; then\n    case $words[1] in\n";
    for (const CommandText& command : program.commands) {
      text += "      " + command.word() + ") _arguments -s" + zsh_specs(command) + " ;;\n";
    }
    text += "    esac\n  fi\n";
    text += "  case $state in\n    commands) _describe command commands ;;\n";
    text += "    jobs) local -a jobs=(${(f)\"$(";
    text += list_jobs;
    text += ")\"}); compadd -a jobs ;;\n  esac\n";
  }
  return text + "}\n" + function + " \"$@\"\n";
}

std::string fish_completion(const ProgramText& program) {
  std::string text = header(program, "fish");
  text += "complete -c " + program.self.name + " -f\n";
  for (const CommandText& command : program.commands) {
    text += "complete -c " + program.self.name + " -n __fish_use_subcommand -a " + command.word() +
            " -d " + quoted(command.about) + "\n";
  }
  text += fish_lines(program, program.self);
  for (const CommandText& command : program.commands) text += fish_lines(program, command);
  return text;
}

}  // namespace parray::process
