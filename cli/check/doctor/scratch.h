#pragma once

#include <filesystem>

#include "common/rooms.h"

namespace parray::doctor {

/// A temporary directory for all checks. The destructor removes it with its contents.
class Scratch {
 public:
  Scratch() = default;
  ~Scratch();
  Scratch(const Scratch&) = delete;
  Scratch& operator=(const Scratch&) = delete;

  /// Makes the directory in the system's directory for temporary files (TMPDIR, or /tmp). Call
  /// once. Throws RunError if the directory cannot be made.
  void make();
  [[nodiscard]] bool made() const { return !path_.empty(); }
  /// Returns the directory; empty before make().
  [[nodiscard]] const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

}  // namespace parray::doctor
