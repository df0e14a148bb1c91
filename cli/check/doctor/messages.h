#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "cli/check/doctor/check.h"
#include "proto/clock.h"

/// Checks the messages between processes: ZeroMQ over this machine's loopback, and MPI.
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

struct MpiTrial {
  std::optional<std::filesystem::path> mpirun;  ///< nothing: there is none in PATH
  std::filesystem::path parray_mpi;             ///< the program; it may be missing
  std::filesystem::path directory;              ///< for scene, picture, report and log; must exist
  std::string image_sha256;                     ///< of the correct pixels, 64 hexadecimal digits
  Time limit = seconds(30);                     ///< longest duration of mpirun
};

/// Renders doctor_scene() with two ranks. Skipped without mpirun or parray-mpi. Fails if mpirun
/// fails or takes longer than the limit, if the picture differs, or if the number of ranks is not
/// 2. Warns if the ranks exchanged results by messages instead of an MPI window (one-sided
/// communication).
CheckResult check_mpi_trial(const MpiTrial& trial);

}  // namespace parray::doctor
