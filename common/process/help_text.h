#pragma once

#include <cstddef>
#include <string>

#include "common/process/description.h"

/// The output of --help.
namespace parray::process {

/// Return the help of the whole program or of one of its commands. Lines have at most `columns`
/// characters, unless a word or an example is longer. `all`: include options that are rarely
/// needed.
std::string help_text(const ProgramText& program, std::size_t columns);
std::string help_text(const CommandText& command, std::size_t columns, bool all = false);

/// Returns the width of a help text: COLUMNS if it is a positive number, otherwise the width of the
/// terminal behind stdout, otherwise 80. The result is at least 40, and at most 100, because longer
/// lines are hard to read.
std::size_t help_columns();

/// Returns `text` in lines of at most `columns` characters, unless a word is longer. All lines but
/// the first begin with `indent` spaces: the caller has written the first `indent` columns of the
/// first line.
std::string wrapped(const std::string& text, std::size_t indent, std::size_t columns);

}  // namespace parray::process
