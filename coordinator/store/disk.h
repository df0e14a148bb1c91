#pragma once

#include <sys/types.h>

#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
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

/// An open file or directory. The destructor closes it. Never blocks: a pipe or device in the place
/// of a file is an error (EINVAL).
class OpenPath {
 public:
  /// `flags` as for open(2).
  OpenPath(const std::filesystem::path& path, int flags);
  ~OpenPath();
  OpenPath& operator=(OpenPath&&) = delete;
  /// Returns the descriptor. -1: opening failed, and errno gives the reason.
  [[nodiscard]] int get() const { return fd_; }
  /// Fills `bytes` with the file's bytes from `offset` on. Returns how many there were, fewer only
  /// at the end of the file. -1: reading failed, and errno gives the reason.
  [[nodiscard]] ssize_t read(std::span<char> bytes, std::uint64_t offset) const;

 private:
  int fd_;
};

/// Returns the content of a small file; nothing: it cannot be read.
std::optional<std::string> text_of_file(const std::filesystem::path& file);

/// Size and XXH3-64 of a file that is written once and never changed.
struct WholeFile {
  std::uint64_t bytes = 0;
  std::uint64_t checksum = 0;
  friend bool operator==(const WholeFile&, const WholeFile&) = default;
};

/// Returns size and checksum of a file that consists of these pieces in order.
WholeFile whole_file_of(std::span<const std::string_view> pieces);

/// Reads a file and returns its size and checksum; nothing: it cannot be read.
std::optional<WholeFile> measure(const std::filesystem::path& file);

}  // namespace parray::store
