#pragma once

#include <string>

#include "common/process/description.h"

/// Man pages (man(7) macros) of section 1. A command's `manual` is text in a simple form. Empty
/// lines separate paragraphs. "# Heading" begins a section. "- " begins a point of a list, and its
/// further lines are indented by two spaces. Lines indented by four spaces stay unchanged. `words`
/// in backticks are literal.
namespace parray::process {

/// Returns the page of the program, parray.1, with its commands and their headings if it has any.
std::string manual_page(const ProgramText& program);
/// Returns the page of one of its commands: parray-render.1.
std::string manual_page(const ProgramText& program, const CommandText& command);

}  // namespace parray::process
