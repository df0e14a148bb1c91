#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "common/rooms.h"

namespace parray::scene_sandbox {

/// The permissions of a process that reads untrusted uploads.
struct Enclosure {
  std::filesystem::path directory;  ///< the only directory for reading and writing
  std::uint64_t file_bytes = 0;     ///< size of the largest file that it may write
};

/// Confines this process. It can then open files only in `directory`, and read libraries and fonts.
/// It cannot make sockets, start programs, or access other processes. This needs a kernel with
/// Landlock (https://docs.kernel.org/userspace-api/landlock.html) and seccomp(2); older kernels
/// enforce less. Call while the process has one thread. Throws RunError if a limit that every
/// kernel knows cannot be set.
void enclose_process(const Enclosure& enclosure);

/// Tries forbidden actions and returns those that succeed: "reads FILE", "makes sockets", ...
/// Empty: all are refused. `enclosure`: that of enclose_process(); tries to write a file of one
/// byte more than `file_bytes`. `file`: a file outside the directory that the user may read.
std::vector<std::string> ways_out(const Enclosure& enclosure, const std::filesystem::path& file);

}  // namespace parray::scene_sandbox
