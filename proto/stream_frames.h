#pragma once

#include <cstdint>
#include <optional>

#include "proto/frame.h"

namespace parray::proto {

/// Frames over a stream socket between a program and its helper process: their number (4 bytes),
/// the size of each (8 bytes), then their bytes. Both ends are the same release on one machine. The
/// functions block. Several threads may call them at the same time for different sockets.

/// Writes frames. Returns false if the other end is closed or the socket is unusable.
bool write_frames(int socket, const Frames& frames);

/// Reads frames. Returns nothing if the other end is closed, the socket is unusable, or there are
/// more than 16 frames or more than `most_bytes` bytes in total.
std::optional<Frames> read_frames(int socket, std::uint64_t most_bytes);

}  // namespace parray::proto
