#pragma once

#include <string>

#include "cli/input/particles/file_start.h"
#include "cli/input/particles/packed_file.h"

namespace parray::input {

/// The first character of the file after blanks and a byte order mark; 0: there is none. Reads on
/// where the start of the file holds nothing but blanks.
char first_character(PackedFile& file);

/// What a file that begins with a brace or a bracket seems to be instead of a scene, and the
/// remedy: "a table of pandas as JSON: ..."; empty: it may be a scene. `first` is its
/// first_character(). Judges by the first bytes only.
std::string json_without_scene(const FileStart& start, char first);

/// Whether text of two or four bytes a character begins with a brace (UTF-16 or UTF-32 without a
/// byte order mark).
bool is_wide_json(const FileStart& start);

}  // namespace parray::input
