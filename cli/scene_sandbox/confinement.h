#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "common/rooms.h"

namespace parray::scene_sandbox {

/// The permissions of a process that reads untrusted uploads.
struct Enclosure {
  std::filesystem::path directory;  ///< the only directory in which it may read and write files
  /// Size of the largest file that it may write, in bytes; 0: empty files only.
  std::uint64_t file_bytes = 0;
};

/// Confines this process until it ends. It can then open files only in `directory`, except that it
/// may read libraries, fonts and some system files such as /proc/self. It can write no larger file
/// than `file_bytes`. It cannot make sockets, start programs, or access other processes. Call while
/// the process has one thread. Throws RunError if the limit of file sizes, or the flag
/// no_new_privs, cannot be set.
///
/// All limits except that of file sizes need a kernel with Landlock
/// (https://docs.kernel.org/userspace-api/landlock.html) and seccomp(2). A kernel without Landlock
/// does not limit which files are opened. A kernel without seccomp, or another processor than
/// x86-64 and aarch64, does not limit sockets, programs and processes. enclose_process() does not
/// report missing limits; ways_out() finds them.
void enclose_process(const Enclosure& enclosure);

/// Tries forbidden actions and returns those that succeed: "reads FILE", "makes sockets", ...
/// Empty: all are refused. Call after enclose_process(), with the same `enclosure`. One action
/// tries to write a file of `file_bytes` + 1 bytes. `file`: a file outside `enclosure.directory`
/// that this process could read before enclose_process().
std::vector<std::string> ways_out(const Enclosure& enclosure, const std::filesystem::path& file);

}  // namespace parray::scene_sandbox
