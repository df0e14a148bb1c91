#pragma once

#include <filesystem>
#include <string>

#include "cli/input/particles/packed_file.h"

/// Names what files are that ParRay does not read, so that messages can tell a remedy.
namespace parray::input {

/// Returns what a file seems to be that ParRay does not read, and the remedy: "an HTML page: was
/// the download refused?". Returns an empty text if it knows nothing. `name`: that of the unpacked
/// file. Call it after the recognisers of all supported formats.
std::string unsupported_format(const FileStart& start, const std::filesystem::path& name);

/// Returns the first printable words of a text, in quotes, or what is known of binary data.
std::string first_words(const FileStart& start);

/// Returns the first character of the file after blanks and a byte order mark; 0 if there is none.
/// Reads on if the start of the file contains only blanks.
char first_character(PackedFile& file);

/// Returns what a file that begins with a brace or a bracket seems to be instead of a scene, and
/// the remedy: "a table of pandas as JSON: ...". Returns an empty text if it may be a scene.
/// `first` is the file's first_character(). Looks at the first bytes only.
std::string json_without_scene(const FileStart& start, char first);

}  // namespace parray::input
