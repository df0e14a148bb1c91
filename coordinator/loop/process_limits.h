#pragma once

#include <cstddef>

#include "common/rooms.h"

namespace parray::coordinator {

/// Results come and go in blocks of up to 32 MiB: what was freed is used again, instead of being
/// given back to the system and cleared anew for each.
void keep_freed_blocks();

/// Every worker, every client and every connection of HTTP is a file descriptor. Throws InputError
/// when there cannot be enough.
void allow_connections(std::size_t workers, std::size_t http);

}  // namespace parray::coordinator
