#pragma once

#include <string>

#include "common/rooms.h"

namespace parray::commands {

/// What the man page of a command says beyond its options, in the form of
/// common/process/manual_page.h: of "render", say, or of "mpi". Empty: nothing.
std::string manual_of(const std::string& command);

}  // namespace parray::commands
