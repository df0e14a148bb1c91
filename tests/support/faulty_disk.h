#pragma once

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <limits>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "coordinator/store/disk.h"
#include "tests/support/rooms.h"

namespace parray::test {

/// A disk that becomes full, fails to sync or to rename, or stops at any step.
class FaultyDisk final : public Disk {
 public:
  static constexpr std::uint64_t endless = std::numeric_limits<std::uint64_t>::max();

  std::uint64_t room = endless;  ///< bytes that fit before ENOSPC; the last write may be partial
  /// Number of syncs that fail with EIO. As on Linux, everything written since the last sync is
  /// then lost, and the next sync does not report it.
  int failing_syncs = 0;
  int error = 0;                   ///< every write fails with this errno; 0: writes succeed
  int failing_renames = 0;         ///< number of renames that fail with ENOSPC
  int file_syncs = 0;              ///< number of syncs of single files so far
  int file_system_syncs = 0;       ///< number of syncs of the file system so far
  std::function<void()> before{};  ///< called before every step; may throw to end the step

  ssize_t write(int file, std::string_view bytes, std::uint64_t offset) override {
    step();
    if (error != 0) {
      errno = error;
      return -1;
    }
    if (room == 0 && !bytes.empty() && overwritten(file, bytes, offset) == 0) {
      errno = ENOSPC;
      return -1;
    }
    const std::uint64_t free = room == endless ? endless : room + overwritten(file, bytes, offset);
    const ssize_t written =
        Disk::write(file, bytes.substr(0, std::min(free, bytes.size())), offset);
    if (written > 0 && room != endless) {
      room = std::min(room, free - static_cast<std::uint64_t>(written));
    }
    unsynced_[identity(file)].push_back({path_of(file), offset, written});
    return written;
  }
  int sync(int file) override {
    step();
    ++file_syncs;
    const auto unsynced = std::exchange(unsynced_[identity(file)], {});
    if (failing_syncs == 0) return Disk::sync(file);
    --failing_syncs;
    lose(unsynced);
    errno = EIO;
    return -1;
  }
  int sync_directory(int directory) override {
    step();
    return Disk::sync_directory(directory);
  }
  int sync_file_system(int directory) override {
    step();
    ++file_system_syncs;
    const auto unsynced = std::exchange(unsynced_, {});
    if (failing_syncs == 0) return Disk::sync_file_system(directory);
    --failing_syncs;
    for (const auto& [file, writes] : unsynced) lose(writes);
    errno = EIO;
    return -1;
  }
  int rename(const char* from, const char* onto) override {
    step();
    if (failing_renames > 0) {
      --failing_renames;
      errno = ENOSPC;
      return -1;
    }
    return Disk::rename(from, onto);
  }

 private:
  void step() const {
    if (before) before();
  }

  /// Returns the number of bytes that replace existing ones and so need no room.
  static std::uint64_t overwritten(int file, std::string_view bytes, std::uint64_t offset) {
    struct stat status {};
    fstat(file, &status);
    const auto size = static_cast<std::uint64_t>(status.st_size);
    return std::min<std::uint64_t>(bytes.size(), size > offset ? size - offset : 0);
  }
  static ino_t identity(int file) {
    struct stat status {};
    fstat(file, &status);
    return status.st_ino;
  }

  static std::string path_of(int file) {
    return std::filesystem::read_symlink("/proc/self/fd/" + std::to_string(file));
  }

  struct Write {
    std::string file;
    std::uint64_t offset = 0;
    ssize_t size = 0;
  };
  void lose(const std::vector<Write>& writes) {
    for (const Write& write : writes) {
      const int file = open(write.file.c_str(), O_WRONLY | O_CLOEXEC);
      if (file >= 0) {
        Disk::write(file, std::string(static_cast<std::size_t>(write.size), '\0'), write.offset);
        close(file);
      }
    }
  }

  std::map<ino_t, std::vector<Write>> unsynced_;
};

}  // namespace parray::test
