#pragma once

#include <spdlog/logger.h>

#include <cstddef>
#include <memory>
#include <string>
#include <vector>

#include "common/process/command_line.h"

namespace parray::log {

/// How a service logs: --log-level and --log-format.
struct LogOptions {
  std::string level = "info";
  std::string format = "text";

  /// `levels`: explanation of --log-level.
  void add_to(CommandLine& line, const std::string& levels);
};

/// A log on stderr, a line for each event, any thread. As text for people; or as JSON, one object
/// with `time` (RFC 3339, with microseconds and the zone's offset), `level`, `logger` and
/// `message`.
std::shared_ptr<spdlog::logger> make_log(const std::string& name, const LogOptions& options);

/// Keeps the last lines of a log in memory, whatever its format, for people. Any thread may call
/// it.
class RecentLines {
 public:
  /// Adds itself to `log`, which must not be in use by another thread yet.
  RecentLines(spdlog::logger& log, std::size_t most);

  /// Returns the lines, oldest first, without their ends.
  [[nodiscard]] std::vector<std::string> lines() const;

 private:
  class Sink;
  std::shared_ptr<Sink> sink_;
};

}  // namespace parray::log
