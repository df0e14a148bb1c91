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
  /// Size of the largest file that it may write, in bytes; 0: empty files only.
  std::uint64_t file_bytes = 0;
};

/// Confines this process until it ends. It can then open files only in `directory`, read libraries
/// and fonts, and write no larger file than `file_bytes`. It cannot make sockets, start programs,
/// or access other processes. Call while the process has one thread. Throws RunError if the limit
/// of file sizes, or the flag no_new_privs, cannot be set.
///
/// All limits except that of file sizes need a kernel with Landlock
/// (https://docs.kernel.org/userspace-api/landlock.html) and seccomp(2). A kernel without Landlock
/// does not limit which files are opened. A kernel without seccomp does not limit sockets, programs
/// and processes. Neither is an error: see ways_out().
void enclose_process(const Enclosure& enclosure);

/// Tries forbidden actions and returns those that succeed: "reads FILE", "makes sockets", ...
/// Empty: all are refused. `enclosure`: the argument of the previous enclose_process(). One action
/// writes a file of `file_bytes` + 1 bytes. `file`: a file outside `enclosure.directory` that the
/// user of this process may read.
std::vector<std::string> ways_out(const Enclosure& enclosure, const std::filesystem::path& file);

}  // namespace parray::scene_sandbox
