#pragma once

#include <string>
#include <vector>

#include "common/rooms.h"

/// Commands that `parray plan` and `parray tradeoff` print for the user to copy.
namespace parray::commands {

/// The words as one line that a POSIX shell reads as these words.
std::string shell_line(const std::vector<std::string>& words);

/// The scene's file name with .exr, without its folder.
std::string default_picture(const std::string& scene);

}  // namespace parray::commands
