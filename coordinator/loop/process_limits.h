#pragma once

#include <cstddef>

#include "common/rooms.h"

namespace parray::coordinator {

/// Makes malloc reuse freed blocks of up to 64 MiB. Results take blocks of up to 32 MiB; otherwise
/// malloc would return each to the system, which clears every new one.
void keep_freed_blocks();

/// Raises the limit of open files as far as possible. Every worker, client and HTTP connection uses
/// a file descriptor. Throws InputError if the limit is too low.
void allow_connections(std::size_t workers, std::size_t http);

}  // namespace parray::coordinator
