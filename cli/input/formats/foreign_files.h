#pragma once

#include <filesystem>
#include <string>

#include "cli/input/particles/file_start.h"

namespace parray::input {

/// What a file seems to be that ParRay does not read, and the remedy: "an HTML page: was the
/// download refused?"; empty when it is nothing known. Asked after every format that is read.
std::string foreign_file(const FileStart& start, const std::filesystem::path& name);

/// The first printable words of a text, in quotes, or what is known of binary data.
std::string first_words(const FileStart& start);

}  // namespace parray::input
