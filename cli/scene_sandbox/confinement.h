#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "common/rooms.h"

/// Limits and files of parray-http-child, the process that a coordinator starts for one HTTP
/// request. Its current directory has the files of the request. It writes pictures there, and jobs
/// and forecasts to the parent directory.
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

/// Limits of parray-http-child.
struct ChildResources {
  std::size_t memory = 0;   ///< address space in bytes
  std::size_t seconds = 0;  ///< processor time in seconds
};

/// Returns the permissions of this process: access to the parent of its current directory and all
/// folders in it, and files of at most `file_bytes` bytes.
Enclosure enclosure_of(std::uint64_t file_bytes);

/// Limits memory and processor time (SIGXCPU ends the process), and calls enclose_process() with
/// enclosure_of(file_bytes): a malicious upload may take this process over. Makes the process end
/// when its parent ends. Throws RunError if a limit cannot be set. Builds with sanitizers limit
/// only processor time.
void confine(const ChildResources& resources, std::uint64_t file_bytes);

/// keep_bytes() writes a file, kept_bytes() reads a whole file. Both throw RunError if that fails.
void keep_bytes(const std::filesystem::path& file, std::string_view bytes);
std::string kept_bytes(const std::filesystem::path& file);

}  // namespace parray::scene_sandbox
