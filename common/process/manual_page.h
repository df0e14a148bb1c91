#pragma once

#include <string>

#include "common/process/description.h"

/// Man pages (man(7) macros), section 1. A command's `manual` is text in a simple form: paragraphs
/// between empty lines; "# Heading" begins a section; "- " a point of a list, whose further lines
/// are indented by two spaces; what is indented by four spaces stays as it is; `words` in backticks
/// are literal.
namespace parray::process {

/// Of the program: parray.1. With its commands, if it has any, and their headings.
std::string manual_page(const ProgramText& program);
/// Of one of its commands: parray-render.1.
std::string manual_page(const ProgramText& program, const CommandText& command);

}  // namespace parray::process
