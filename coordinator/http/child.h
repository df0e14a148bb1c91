#pragma once

#include <atomic>
#include <filesystem>
#include <string>
#include <vector>

#include "common/base/files.h"
#include "common/process/child.h"
#include "proto/clock.h"

namespace parray::http {

/// Creates a directory for one request in `parent`, accessible to this user only. Throws RunError.
OwnedPath work_directory(const std::filesystem::path& parent);

/// Limits of a child process.
struct ChildLimits {
  std::uint64_t memory = std::uint64_t{2} << 30;  ///< bytes of address space
  std::size_t seconds = 60;                       ///< processor time
};

/// Returns the limit of elapsed time, in seconds: twice that of processor time.
constexpr std::size_t elapsed_seconds(const ChildLimits& limits) { return 2 * limits.seconds; }

/// Runs parray-http-child (cli/scene_sandbox/main.cpp) as a child process at low priority. The
/// child inherits no file, socket or lock of this process. Callable from any thread.
class ChildRunner {
 public:
  /// Throws RunError if the program is missing.
  ChildRunner();

  /// Runs the child with the arguments `wanted` after those for the limits. Waits until it ends, or
  /// kills it at the limit of elapsed time (ChildEnd::timed_out). ChildEnd::signal is SIGXCPU, with
  /// timed_out, if it reached the limit of processor time. `directory`: its working directory.
  /// Throws RunError if the child cannot be started, or if stop() is called.
  ChildEnd run(const std::vector<std::string>& wanted, const std::filesystem::path& directory,
               const ChildLimits& limits) const;

  /// Kills running children. Running and later calls of run() throw RunError.
  void stop() { stopped_ = true; }

 private:
  const std::filesystem::path program_;
  std::atomic<bool> stopped_ = false;
};

}  // namespace parray::http
