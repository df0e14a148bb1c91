#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "common/log/logger.h"
#include "common/process/command_line.h"

namespace parray::log {

/// How a service logs: the values of --log-level and --log-format.
struct LogOptions {
  std::string level = "info";   ///< least severe events to log: debug, info, warn, error
  std::string format = "text";  ///< text, json

  /// Declares both options. `levels`: the help of --log-level.
  void add_to(CommandLine& line, const std::string& levels);
};

/// Makes a log that writes a line to stderr for each event. Any thread may use the log. A line is
/// text for people, with control characters as escapes, or a JSON object with `time` (RFC 3339,
/// with microseconds and the zone's offset), `level`, `logger` (which is `name`) and `message`.
/// Throws spdlog::spdlog_ex if the process already has a log called `name`.
std::shared_ptr<spdlog::logger> make_log(const std::string& name, const LogOptions& options);

/// Makes `log` also keep its last `most` lines in memory, as text with escapes. Must be called
/// before another thread uses `log`. Returns a function that returns these lines, oldest first,
/// without line ends. Any thread may call that function.
std::function<std::vector<std::string>()> keep_lines(spdlog::logger& log, std::size_t most);

}  // namespace parray::log
