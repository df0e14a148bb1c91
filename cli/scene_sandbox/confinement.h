#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "common/rooms.h"

namespace parray::scene_sandbox {

/// What a process may still do that reads what strangers have sent.
struct Enclosure {
  std::filesystem::path directory;  ///< where it may read and write
  std::uint64_t file_bytes = 0;     ///< largest file that it may write
};

/// From now on this process can neither open files outside `directory`, but for libraries and fonts
/// to read, nor make sockets, start programs, or look into other processes; as far as the kernel
/// knows Landlock (https://docs.kernel.org/userspace-api/landlock.html) and seccomp(2). Call it
/// while there is one thread. Throws RunError when a limit that every kernel knows cannot be set.
void enclose_process(const Enclosure& enclosure);

/// What this process can do of that all the same, tried: "reads FILE", "makes sockets", ... Empty:
/// nothing. `file`: one outside that its user can read. `file_bytes`: as it was enclosed with; a
/// file of one byte more is tried in `directory`.
std::vector<std::string> ways_out(const Enclosure& enclosure, const std::filesystem::path& file);

}  // namespace parray::scene_sandbox
