#pragma once

#include <cstdint>
#include <optional>

#include "proto/frame.h"

namespace parray::proto {

/// Frames over a stream socket between a program and its helper process: their number (4 bytes),
/// the size of each (8 bytes), then their bytes. Both ends are the same release on one machine.
/// Blocking; any thread.

/// False: the other end is closed, or the socket is no good.
bool write_frames(int socket, const Frames& frames);

/// Nothing: the other end is closed, the socket is no good, or what comes is no frames of at most
/// `most_bytes` together.
std::optional<Frames> read_frames(int socket, std::uint64_t most_bytes);

}  // namespace parray::proto
