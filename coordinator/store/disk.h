#pragma once

#include <sys/types.h>

#include <cstdint>
#include <string_view>

#include "common/rooms.h"

namespace parray::store {

/// The system calls that write bulk data to the disk. Tests replace them to simulate full disks and
/// power failures. Each returns -1 and sets errno on failure. Stateless and thread-safe.
class Disk {
 public:
  virtual ~Disk() = default;
  Disk& operator=(Disk&&) = delete;

  /// Calls pwrite. Returns the number of bytes written, which may be fewer than given.
  virtual ssize_t write(int file, std::string_view bytes, std::uint64_t offset);
  virtual int sync(int file);                 ///< calls fdatasync
  virtual int sync_directory(int directory);  ///< calls fsync
  /// Calls syncfs for the file system of this directory.
  virtual int sync_file_system(int directory);
  virtual int rename(const char* from, const char* onto);  ///< calls rename
};

/// Returns the Disk that makes the real system calls.
Disk& system_disk();

}  // namespace parray::store
