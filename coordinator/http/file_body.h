#pragma once

#include <cstddef>
#include <filesystem>
#include <memory>
#include <string_view>

#include "coordinator/http/budget.h"

namespace parray::http {

/// A file that is sent as it lies on the disk, to any number of readers, however slow: it takes no
/// memory of this process. It has no name any more; its bytes are free when nobody has this.
class FileBody {
 public:
  /// Takes over `file`, which is deleted. Throws Problem 503 when `disk` has no room for it,
  /// RunError when it cannot be opened.
  FileBody(const std::filesystem::path& file, Budget& disk);
  ~FileBody();
  FileBody(const FileBody&) = delete;
  FileBody& operator=(const FileBody&) = delete;

  [[nodiscard]] int descriptor() const { return file_; }
  /// Where its bytes would be found; nobody reads them there, or they would be in memory.
  [[nodiscard]] std::string_view bytes() const { return bytes_; }

 private:
  int file_ = -1;
  std::string_view bytes_;
  Budget::Hold held_;
};

}  // namespace parray::http
