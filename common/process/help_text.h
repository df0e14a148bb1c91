#pragma once

#include <cstddef>
#include <string>

#include "common/process/description.h"

/// What --help prints.
namespace parray::process {

/// Of the whole program; of one of its commands. Lines have at most `columns` characters, where
/// words and examples allow. `all`: with the options for experiments.
std::string help_text(const ProgramText& program, std::size_t columns);
std::string help_text(const CommandText& command, std::size_t columns, bool all = false);

/// How wide a help may be: COLUMNS if it is a number, else the width of the terminal behind stdout,
/// else 80; 40 at least, and 100 at most, beyond which lines are hard to read.
std::size_t help_columns();

/// `text` in lines of at most `columns` characters, each after `indent` spaces but the first.
std::string wrapped(const std::string& text, std::size_t indent, std::size_t columns);

}  // namespace parray::process
