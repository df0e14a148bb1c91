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

/// Returns the first character of the file after blanks and a byte order mark. Returns 0 if there
/// is none. Reads beyond the start of the file if that contains only blanks.
char first_character(PackedFile& file);

/// Returns what a file that begins with a brace or a bracket seems to be instead of a scene, and
/// the remedy: "a table as JSON (from pandas), not a scene: ...". Returns "" if the file may be a
/// scene. `first` is the file's first_character(). Reads only the first bytes.
std::string json_without_scene(const FileStart& start, char first);

}  // namespace parray::input
