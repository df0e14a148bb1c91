#pragma once

#include <spdlog/logger.h>

#include <cstddef>
#include <functional>
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

/// Keeps the last `most` lines of a log in memory, as text. To be called before another thread uses
/// `log`. Returns a function that returns the lines, oldest first, without their ends. Any thread
/// may call it.
std::function<std::vector<std::string>()> keep_lines(spdlog::logger& log, std::size_t most);

}  // namespace parray::log
