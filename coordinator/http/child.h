#pragma once

#include <atomic>
#include <filesystem>
#include <string>
#include <vector>

#include "common/process/child.h"
#include "proto/clock.h"

namespace parray::http {

/// A directory of one request's own, closed to others; gone with this.
class WorkDirectory {
 public:
  /// Below `parent`. Throws RunError.
  explicit WorkDirectory(const std::filesystem::path& parent);
  ~WorkDirectory();
  WorkDirectory(const WorkDirectory&) = delete;
  WorkDirectory& operator=(const WorkDirectory&) = delete;

  [[nodiscard]] const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

/// What a child may use.
struct ChildLimits {
  std::uint64_t memory = std::uint64_t{2} << 30;  ///< bytes of address space
  std::size_t seconds = 60;                       ///< of processor time; twice that by the clock
};

/// Runs parray-http-child (cli/scene_sandbox/main.cpp) beside everything else: at low priority,
/// without any file, socket or lock of this process. Any thread.
class ChildRunner {
 public:
  /// Throws RunError when the program is not there.
  ChildRunner();

  /// Waits until the child has ended. `directory` is its current one. Throws
  /// RunError when it cannot be started, or after stop().
  ChildEnd run(const std::vector<std::string>& arguments, const std::filesystem::path& directory,
               const ChildLimits& limits) const;

  /// Ends what runs, and what would run later.
  void stop() { stopped_ = true; }

 private:
  const std::filesystem::path program_;
  std::atomic<bool> stopped_ = false;
};

}  // namespace parray::http
