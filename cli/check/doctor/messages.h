#pragma once

#include <filesystem>

#include "cli/check/doctor/check.h"
#include "proto/clock.h"

/// Checks ZeroMQ over this machine's loopback.
namespace parray::doctor {

/// Sends a message from a worker's link to a coordinator's link and back, within `patience`.
CheckResult check_messages(Time patience);

/// Behaviour of the server's authenticator. Only tests use wrong ones.
enum class KeyTrial : std::uint8_t { honest, accepts_anybody, refuses_everybody };

/// Makes new keys in a folder of `directory`. A server with CURVE must accept the message of a
/// client with a known key and refuse a client with an unknown key.
CheckResult check_keys(Time patience, const std::filesystem::path& directory,
                       KeyTrial trial = KeyTrial::honest);

}  // namespace parray::doctor
