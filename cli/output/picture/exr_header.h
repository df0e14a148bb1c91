#pragma once

#include <filesystem>

#include "common/rooms.h"

namespace parray::picture {

/// Refuses an EXR file with an attribute that is longer than the rest of the file: OpenEXR takes,
/// and clears, as much memory as the attribute's size says before it reads it, up to 2 GiB.
/// Whatever else is wrong, or no EXR file, is left to the library. Throws InputError "FILE:
/// reason".
///
/// Format: https://openexr.com/en/latest/OpenEXRFileLayout.html
void check_exr_attributes(const std::filesystem::path& path);

}  // namespace parray::picture
