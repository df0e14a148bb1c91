#pragma once

#include <cstddef>
#include <string>

#include "common/process/description.h"

/// What --help prints.
namespace parray::process {

/// Returns the help of a program or of one of its commands. Lines have at most `columns`
/// characters, except for long words and examples. `all` includes the options for experiments.
std::string help_text(const ProgramText& program, std::size_t columns);
std::string help_text(const CommandText& command, std::size_t columns, bool all = false);

/// Returns the width of a help: COLUMNS if it is a number, otherwise the width of the terminal
/// behind stdout, otherwise 80; at least 40 and, for legible lines, at most 100.
std::size_t help_columns();

/// Returns `text` in lines of at most `columns` characters. All lines except the first begin with
/// `indent` spaces.
std::string wrapped(const std::string& text, std::size_t indent, std::size_t columns);

}  // namespace parray::process
