#pragma once

#include <filesystem>
#include <string>

#include "cli/input/particles/packed_file.h"

/// Recognises files that ParRay does not support, so that messages can name a remedy.
namespace parray::input {

/// Returns what an unsupported file seems to be, and the remedy: "an HTML page: check that the
/// download succeeded". Returns "" if it is unknown. `name` is the name of the unpacked file. Call
/// it after the recognisers of all supported formats.
std::string unsupported_format(const FileStart& start, const std::filesystem::path& name);

/// Returns the first printable words of a text, in quotes, or a description of binary data.
std::string first_words(const FileStart& start);

}  // namespace parray::input
