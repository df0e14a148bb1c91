#pragma once

#include <cstddef>

#include "common/rooms.h"

namespace parray::coordinator {

/// Makes malloc reuse freed blocks of up to 64 MiB. Results take blocks of up to 32 MiB; otherwise
/// malloc would return each to the system, which clears every new one.
void keep_freed_blocks();

/// Raises the limit of open files of this process as far as the system allows. Each of `workers`
/// workers and `http` HTTP connections needs a file descriptor. Clients, files and ZeroMQ need up
/// to 256 more. Throws InputError if the raised limit is less than the sum of these three.
void allow_connections(std::size_t workers, std::size_t http);

}  // namespace parray::coordinator
