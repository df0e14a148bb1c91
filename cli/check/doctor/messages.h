#pragma once

#include <filesystem>

#include "cli/check/doctor/check.h"
#include "proto/clock.h"

/// ZeroMQ over this machine's loopback.
namespace parray::doctor {

/// A message from a worker's link to a coordinator's and back, within `patience`.
Finding check_messages(Time patience);

/// What a server's authenticator does: for tests, other than its duty.
enum class KeyTrial : std::uint8_t { honest, accepts_anybody, refuses_everybody };

/// Fresh keys, in a folder of `directory`: a server with CURVE that knows one client's key gets
/// this client's message and refuses a stranger's.
Finding check_keys(Time patience, const std::filesystem::path& directory,
                   KeyTrial trial = KeyTrial::honest);

}  // namespace parray::doctor
