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

}  // namespace parray::input
