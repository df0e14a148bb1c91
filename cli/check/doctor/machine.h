#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>

#include "cli/check/doctor/check.h"
#include "common/base/files.h"

/// Checks processor, floating-point mode, memory, disks, linked libraries, and files that these
/// write and read back.
namespace parray::doctor {

/// Reports the processor's model, the number of usable CPUs and the instruction sets. Always
/// passes.
CheckResult check_processor();
/// Checks control words (common/math/float_mode.h), one for each thread: rounding, denormals,
/// exception masks. Every bit of a picture depends on them. Warns if one differs from the default
/// of IEEE 754, as after -ffast-math in a library. Never fails, because tracing sets its own mode
/// (FloatMode).
CheckResult check_float_mode(std::span<const unsigned> found);
/// Does the same for this thread and a team of usable_cpus() OpenMP threads.
CheckResult check_float_mode();

/// Warns if less than 256 MiB of memory are available. Skipped if a number is 0: unknown.
CheckResult check_memory(std::uint64_t available, std::uint64_t total);
/// Does the same for the memory of this system.
CheckResult check_memory();

/// Makes the directory for files of later checks, in the system's directory for temporary files
/// (TMPDIR), and sets `scratch` to it. Fails if the directory cannot be made or written. If it
/// cannot be made, `scratch` stays unchanged. OwnedPath removes the directory at its end.
CheckResult check_temporary_directory(std::optional<OwnedPath>& scratch);
/// Warns if no file can be made and written in `directory`.
CheckResult check_current_directory(const std::filesystem::path& directory);

/// Returns the bytes of shared memory that parray-mpi with one rank per usable CPU needs for a
/// picture of 1200 x 800 pixels, the default size. They are the MPI window, in which the ranks
/// collect results (proto/window.h), and Open MPI's own buffers.
std::uint64_t window_bytes();
/// Warns if `needed` bytes do not fit into `available` bytes of shared memory.
CheckResult check_shared_memory(std::uint64_t available, std::uint64_t needed);
/// Does the same for /dev/shm and window_bytes(). Skipped if there is no /dev/shm.
CheckResult check_shared_memory();

/// Lists versions: of the loaded library if it states one, otherwise of its headers. Fails if the
/// loaded ZeroMQ has another major version than its headers.
CheckResult check_libraries();

/// Writes an EXR and a PNG picture to `directory` and reads them back. Fails if a value of float32
/// (EXR) or a byte (PNG) differs.
CheckResult check_pictures(const std::filesystem::path& directory);

/// Makes a coordinator's state in `directory`/state, commits a scene and opens the state again.
/// Fails if the scene is missing or differs.
CheckResult check_state(const std::filesystem::path& directory);

}  // namespace parray::doctor
