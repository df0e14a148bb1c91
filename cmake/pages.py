#!/usr/bin/env python3
"""pages.py MANUAL DIRECTORY PROGRAM...: writes the man pages and the shell completion of a program to DIRECTORY.

PROGRAM with `--describe json` prints its commands and options. MANUAL is Markdown. The text below `# NAME` is part of
the man page NAME(1). A line `include: FILE "HEADING"` inserts the section HEADING of FILE, without the heading."""

import json
import pathlib
import re
import subprocess
import sys

PROGRAMS = ("parray", "parray-coordinator", "parray-worker", "parray-mpi")
LIST_JOBS = "timeout 1 parray jobs 2>/dev/null | awk 'NR > 1 {print $1}'"


# ---- Markdown -------------------------------------------------------------------------------------------------------

def section(path, heading):
    """Returns the lines below a heading, up to the next heading."""
    lines = path.read_text(encoding="utf-8").splitlines()
    marks = {f"{'#' * level} {heading}" for level in (1, 2, 3)}
    begin = next((i for i, line in enumerate(lines) if line in marks), None)
    if begin is None:
        sys.exit(f"{path} has no heading '{heading}'")
    end = next((i for i in range(begin + 1, len(lines)) if re.match("#+ ", lines[i])), len(lines))
    return lines[begin + 1 : end]


def manuals(path):
    """Returns the lines of each page by the page's name."""
    pages = {}
    for line in path.read_text(encoding="utf-8").splitlines():
        include = re.fullmatch(r'include: (\S+) "(.+)"', line)
        if line.startswith("# "):
            lines = pages.setdefault(line[2:], [])
        elif pages:
            lines += section(path.parent / include[1], include[2]) if include else [line]
    return pages


def blocks(lines):
    """Returns (kind, text) of each block. Kinds: heading, paragraph, literal, head or row of a table, point of a list,
    more (another paragraph of a point)."""
    found = []
    ended = True  # an empty line begins a new block
    for line in lines:
        kind, text = found[-1] if found else ("", "")
        more = kind in ("paragraph", "point", "more") and not ended
        if not line.strip():
            ended = True
            continue
        if re.match("#+ ", line):
            found.append(("heading", line.lstrip("# ")))
        elif line.startswith("    ") and not more:
            if kind == "literal":
                found[-1] = (kind, text + "\n" * (1 + ended) + line[4:])
            else:
                found.append(("literal", line[4:]))
        elif line.startswith("|"):
            if not re.match(r"\|[-:|]+\|$", line):
                found.append(("row" if kind in ("row", "rule") else "head", line.strip("| ")))
            else:
                found[-1] = ("rule", "")
        elif line.startswith("!["):
            pass
        elif line.startswith("- "):
            found.append(("point", line[2:]))
        elif more:
            found[-1] = (kind, text + "\n" + line.strip())
        elif line.startswith("  "):
            found.append(("more", line.strip()))
        else:
            found.append(("paragraph", line.strip()))
        ended = False
    return found


# ---- man pages ------------------------------------------------------------------------------------------------------

ROFF = {"\\": "\\e", "-": "\\-", "'": "\\(aq", "`": "\\(ga", "^": "\\(ha", "~": "\\(ti", '"': "\\(dq"}


def escaped(text):
    return "".join(ROFF.get(c, c) for c in text)


def bold(text):
    return f"\\fB{escaped(text)}\\fR"


def line_of(text):
    """Converts the Markdown within a paragraph. Replaces links by their texts. Leaves out references to tests."""
    text = re.sub(r"\s*\((?:`tests/[^`]*`|\[[^]]*\]\(\.\./tests/[^)]*\))\)", "", text)
    text = re.sub(r"\[([^]]*)\]\([^)]*\)", r"\1", text)
    parts = re.split(r"`([^`]*)`|\*\*([^*]+)\*\*", text)
    out = "".join(escaped(part) if i % 3 == 0 else bold(part) for i, part in enumerate(parts) if part)
    return re.sub(r"(?m)^(?=\.)", r"\\&", out)


def sentence(text):
    """Converts a text and ends it with a period, unless it already ends with one."""
    return line_of(text if text.endswith(".") else text + ".")


def man_text(lines):
    out = ""
    in_list = False
    for kind, text in blocks(lines):
        if kind == "heading":
            out += f'.SH "{escaped(text.upper())}"\n'
        elif kind == "literal":
            literal = re.sub("(?m)^", r"\\&", escaped(text))
            out += f".IP\n.EX\n{literal}\n.EE\n" if in_list else f".PP\n.RS 4\n.EX\n{literal}\n.EE\n.RE\n"
        elif kind == "row":
            *names, meaning = (cell.strip() for cell in text.split("|"))
            out += f".TP\n{' ('.join(map(line_of, names)) + ')' * (len(names) - 1)}\n{line_of(meaning)}\n"
        elif kind in ("paragraph", "point", "more"):
            out += {"paragraph": ".PP", "point": ".IP \\(bu 2", "more": ".IP"}[kind] + f"\n{line_of(text)}\n"
        if kind != "literal":
            in_list = kind in ("point", "more")
    return out


def option_entry(option):
    value = f"\\fI{escaped(option['value'])}\\fR" if option["value"] else ""
    entry = f".TP\n{' '.join(filter(None, (', '.join(map(bold, option['names'])), value)))}\n{sentence(option['text'])}\n"
    if option["default"]:
        entry += f"Default: {bold(option['default'])}.\n"
    if option["environment"]:
        entry += f"The environment variable {bold(option['environment'])} does the same.\n"
    if option["with"]:
        entry += f"Only with {bold(option['with'])}.\n"
    return entry


def headings(entries):
    return dict.fromkeys(entry["heading"] for entry in entries)


def page_of(program, command, manual):
    self = command is program
    about = command["about"]
    named = [option for option in command["options"] if option["names"]]
    arguments = "".join(option_entry(option) for option in command["options"] if not option["names"])
    out = f'.\\" Made by cmake/pages.py.\n.TH "{escaped(command["page"].upper())}" 1 "" "ParRay {program["version"]}" "ParRay"\n'
    out += f".nh\n.ad l\n.ss 12 0\n.SH NAME\n{escaped(command['page'])} \\- {escaped(about[0].lower() + about[1:])}\n"
    out += f".SH SYNOPSIS\n{bold(command['usage'])}\n.SH DESCRIPTION\n{line_of(about)}.\n{man_text(manual)}"
    if self and program["commands"]:
        out += ".SH COMMANDS\n"
        for heading in headings(program["commands"]):
            out += f'.SS "{escaped(heading)}"\n'
            out += "".join(f".TP\n{bold(c['page'])}(1)\n{line_of(c['about'])}.\n" for c in program["commands"] if c["heading"] == heading)
    out += f".SH ARGUMENTS\n{arguments}" if arguments else ""
    out += ".SH OPTIONS\n"
    for heading in headings(named):
        out += f'.SS "{escaped(heading)}"\n' + "".join(option_entry(o) for o in named if o["heading"] == heading)
    out += ".SH EXAMPLES\n" if command["examples"] else ""
    for example in command["examples"]:
        about = example["about"][0].upper() + example["about"][1:]
        out += f".PP\n{line_of(about)}:\n.PP\n.RS 4\n.EX\n\\&{escaped(example['command'])}\n.EE\n.RE\n"
    variables = [option for option in command["options"] if option["environment"]]
    out += ".SH ENVIRONMENT\n" if variables else ""
    for option in variables:
        out += f".TP\n{bold(option['environment'])}\nThe value of {bold(option['names'][0])} if the option is not given.\n"
    others = [name for name in PROGRAMS if name != program["name"]] if self else [
        program["page"], *(c["page"] for c in program["commands"] if c["heading"] == command["heading"] and c is not command)]
    see = ", ".join(f"{bold(name)}(1)" for name in others)
    return out + f'.SH "EXIT STATUS"\n{line_of(program["exit_statuses"])}.\n.SH "SEE ALSO"\n{see}\n'


# ---- completion -----------------------------------------------------------------------------------------------------

def word_of(command):
    return command["name"].split()[-1]


def quoted(text):
    return "'" + text.replace("'", "'\\''") + "'"


def command_words(program):
    return " ".join(map(word_of, program["commands"]))


BASH = r"""@FUNCTION@() {
  local cur=${COMP_WORDS[COMP_CWORD]} command='' option='' kind=nothing flags='' before i at=0
  local -a arguments=()
  local valued=' @VALUED@ '
  COMPREPLY=()
  # Bash treats = as a separate word: "--adaptive=on" is three words.
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
"""


def bash_kind(program, option):
    if option["words"]:
        return quoted(("list " if option["list"] else "words ") + " ".join(option["words"]))
    return quoted("words " + command_words(program)) if option["completes"] == "commands" else option["completes"]


def bash_case(program, command, word):
    flags = " ".join(name for option in command["options"] for name in option["names"])
    arguments = []
    values = ""
    for option in command["options"]:
        kind = bash_kind(program, option)
        if not option["names"]:
            arguments += [kind] * (4 if option["repeats"] else 1)
        elif option["value"] and kind != "nothing":
            values += f"        {'|'.join(option['names'])}) kind={kind} ;;\n"
    values = values and f"      case $option in\n{values}      esac\n"
    return f"    {word})\n      flags={quoted(flags)} arguments=({' '.join(arguments)})\n{values}      ;;\n"


def bash_completion(program):
    commands = program["commands"]
    # An option of the same name takes a value in all commands or in none.
    valued = {name for c in (program, *commands) for option in c["options"] if option["value"] for name in option["names"]}
    parts = {
        "FUNCTION": "_" + program["name"].replace("-", "_"), "PROGRAM": program["name"], "JOBS": LIST_JOBS,
        "VALUED": " ".join(sorted(valued)),
        "CASES": bash_case(program, program, "''") + "".join(bash_case(program, c, word_of(c)) for c in commands),
        "TAKE_COMMAND": "    elif [[ -z $command ]]; then\n      command=${COMP_WORDS[i]}\n" if commands else "",
        "OFFER_COMMANDS": f"    elif [[ -z $command ]]; then\n      kind='words {command_words(program)}'\n" if commands else ""}
    return re.sub("@([A-Z_]+)@", lambda name: parts[name[1]], BASH)


def zsh_action(option):
    words = " ".join(option["words"])
    if words:
        return f"_values -s , word {words}" if option["list"] else f"({words})"
    return {"files": "_files", "directories": "_directories", "jobs": "->jobs", "commands": "->commands"}.get(option["completes"], " ")


def zsh_text(text):
    return re.sub(r"([\\\[\]:])", r"\\\1", text)


def zsh_specs(command):
    """Returns a line of _arguments for each name of each option."""
    lines = []
    for option in command["options"]:
        value = f":{zsh_text(option['value'])}:{zsh_action(option)}" if option["value"] else ""
        if not option["names"]:
            lines.append(("*" if option["repeats"] else "" if option["required"] else ":") + value)
        for name in option["names"]:
            before = "*" if option["repeats"] else f"({' '.join(option['names'])})"
            joint = "" if not value else "=" if name.startswith("--") else "+"
            lines.append(f"{before}{name}{joint}[{zsh_text(option['text'])}]{value}")
    return "".join(f" \\\n        {quoted(line)}" for line in lines)


def zsh_completion(program):
    function = "_" + program["name"].replace("-", "_")
    text = f"#compdef {program['name']}\n{function}() {{\n  local context state state_descr line\n  typeset -A opt_args\n"
    if program["commands"]:
        text += "  local -a commands=(\n"
        text += "".join(f"    {quoted(word_of(c) + ':' + c['about'])}\n" for c in program["commands"])
        text += f"  )\n  _arguments -C{zsh_specs(program)} \\\n        '1:command:->commands' '*::argument:->argument'\n"
        text += "  if [[ $state == argument ]]; then\n    case $words[1] in\n"
        text += "".join(f"      {word_of(c)}) _arguments -s{zsh_specs(c)} ;;\n" for c in program["commands"])
        text += "    esac\n  fi\n  case $state in\n    commands) _describe command commands ;;\n"
        text += f'    jobs) local -a jobs=(${{(f)"$({LIST_JOBS})"}}); compadd -a jobs ;;\n  esac\n'
    else:
        text += f"  _arguments -s{zsh_specs(program)}\n"
    return f'{text}}}\n{function} "$@"\n'


def fish_candidates(program, option):
    words = " ".join(option["words"])
    if words:
        return f" -a {quoted(f'(__fish_append , {words})' if option['list'] else words)}"
    return {"files": " -F", "directories": " -a '(__fish_complete_directories)'", "jobs": f" -a {quoted(f'({LIST_JOBS})')}",
            "commands": f" -a {quoted(command_words(program))}"}.get(option["completes"], "")


def fish_completion(program):
    start = f"complete -c {program['name']}"
    text = f"{start} -f\n"
    for c in program["commands"]:
        text += f"{start} -n __fish_use_subcommand -a {word_of(c)} -d {quoted(c['about'])}\n"
    for c in (program, *program["commands"]):
        condition = ("" if not program["commands"] else " -n __fish_use_subcommand" if c is program
                     else f" -n '__fish_seen_subcommand_from {word_of(c)}'")
        for option in c["options"]:
            candidates = fish_candidates(program, option)
            if not option["names"] and not candidates:
                continue
            names = "".join(f" -l {name[2:]}" if name.startswith("--") else f" -s {name[1:]}" for name in option["names"])
            value = "" if not names or not option["value"] else " -r" if option["completes"] == "files" else " -x"
            text += f"{start}{condition}{names}{value}{candidates} -d {quoted(option['text'])}\n"
    return text


def main():
    manual, directory, command = pathlib.Path(sys.argv[1]), pathlib.Path(sys.argv[2]), sys.argv[3:]
    described = subprocess.run([*command, "--describe", "json"], stdout=subprocess.PIPE, check=False)
    if described.returncode != 0:
        sys.exit(described.returncode)
    program = json.loads(described.stdout)
    prose = manuals(manual)
    name = program["name"]
    files = {f"man/man1/{c['page']}.1": page_of(program, c, prose.get(c["page"], [])) for c in (program, *program["commands"])}
    files |= {f"bash-completion/completions/{name}": bash_completion(program),
              f"zsh/site-functions/_{name}": zsh_completion(program),
              f"fish/vendor_completions.d/{name}.fish": fish_completion(program)}
    for path, text in files.items():
        (directory / path).parent.mkdir(parents=True, exist_ok=True)
        (directory / path).write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
