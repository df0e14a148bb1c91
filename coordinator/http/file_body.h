#pragma once

#include <cstddef>
#include <filesystem>
#include <string_view>

#include "coordinator/http/budget.h"

namespace parray::http {

/// A file that is sent from the disk to any number of clients. Its bytes are mapped to addresses,
/// but stay on the disk: the system sends them from descriptor(). Its directory entry is already
/// deleted, so that the system frees the bytes when the last owner releases this object.
class FileBody {
 public:
  /// Takes over `file` and deletes its directory entry. Holds the size of the file in `disk` until
  /// the end of its life. Throws Problem 503, and keeps the directory entry, if `disk` has no room.
  /// Throws RunError if the file cannot be opened.
  FileBody(const std::filesystem::path& file, Budget& disk);
  ~FileBody();
  FileBody& operator=(FileBody&&) = delete;

  [[nodiscard]] int descriptor() const { return file_; }
  /// Returns the addresses of the mapped file. A pointer into this range stands for an offset in
  /// the file. Do not read the bytes: that would load the file into memory.
  [[nodiscard]] std::string_view bytes() const { return bytes_; }

 private:
  int file_ = -1;
  std::string_view bytes_;
  Budget::Hold held_;
};

}  // namespace parray::http
