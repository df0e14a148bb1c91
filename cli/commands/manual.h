#pragma once

#include <string>

#include "common/rooms.h"

namespace parray::commands {

/// Returns the text of a command's man page beyond its options, in the form of
/// common/process/manual_page.h. `command`: "render", for instance, or "mpi". Empty: no text.
std::string manual_of(const std::string& command);

}  // namespace parray::commands
