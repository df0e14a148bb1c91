#pragma once

#include <filesystem>

#include "cli/check/doctor/check.h"
#include "proto/clock.h"

/// Checks ZeroMQ over this machine's loopback.
namespace parray::doctor {

/// Sends a message from a worker's link to a coordinator's link and back. Fails if that takes
/// longer than `patience`.
CheckResult check_messages(Time patience);

/// Simulated behaviour of the server's authenticator: a correct one, or, for tests, a faulty one.
enum class KeyTrial : std::uint8_t { honest, accepts_anybody, refuses_everybody };

/// Makes new keys in a folder of `directory`. A server with CURVE must accept the message of a
/// client with a known key and refuse a client with an unknown key. Waits for the message at most
/// for `patience`. Fails, too, if ZeroMQ lacks CURVE.
CheckResult check_keys(Time patience, const std::filesystem::path& directory,
                       KeyTrial trial = KeyTrial::honest);

}  // namespace parray::doctor
