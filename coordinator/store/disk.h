#pragma once

#include <sys/types.h>

#include <cstdint>
#include <string_view>

#include "common/rooms.h"

namespace parray::store {

/// The system calls that put bulk data on the disk: the seam behind which tests fill it and pull
/// its plug. Each returns -1 and sets errno on failure. No state, any thread.
class Disk {
 public:
  Disk() = default;
  virtual ~Disk() = default;
  Disk(const Disk&) = delete;
  Disk& operator=(const Disk&) = delete;

  /// pwrite: the number of bytes written, which may be fewer than there are.
  virtual ssize_t write(int file, std::string_view bytes, std::uint64_t offset);
  virtual int sync(int file);                 ///< fdatasync
  virtual int sync_directory(int directory);  ///< fsync
  /// syncfs: all that was written to the file system of this directory.
  virtual int sync_file_system(int directory);
  virtual int rename(const char* from, const char* onto);  ///< rename
};

/// The machine's own.
Disk& system_disk();

}  // namespace parray::store
