#pragma once

#include <filesystem>
#include <string>

#include "cli/input/particles/packed_file.h"

/// Recognises files that ParRay does not support, so that messages can name a remedy.
namespace parray::input {

/// Returns what an unsupported file seems to be, and the remedy: "an HTML page: check that the
/// download succeeded". Returns "" if it is unknown. The caller puts "FILE: looks like " before the
/// text. `start` holds the first unpacked bytes, and `name` is unpacked_name(). Call it after the
/// recognisers of all supported formats, because it may take a supported file for another.
std::string unsupported_format(const FileStart& start, const std::filesystem::path& name);

/// Returns a description of a file for messages: "text that begins with 'ABC'", "only blanks" or
/// "binary data of an unknown kind".
std::string first_words(const FileStart& start);

}  // namespace parray::input
