#pragma once

#include <filesystem>

#include "common/rooms.h"

namespace parray::doctor {

/// A temporary directory for all checks. The destructor removes it with its contents.
class Scratch {
 public:
  ~Scratch();
  Scratch& operator=(Scratch&&) = delete;

  /// Makes the directory in the system's directory for temporary files (TMPDIR). Throws RunError.
  void make();
  [[nodiscard]] bool made() const { return !path_.empty(); }
  [[nodiscard]] const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

}  // namespace parray::doctor
