#pragma once

#include <CLI/CLI.hpp>
#include <string>

namespace parray {

/// One line that says what is wrong with the command line, names the option, the nearest known one
/// if it is unknown, and the help to read.
std::string usage_message(const CLI::App& app, const CLI::ParseError& error);

}  // namespace parray
