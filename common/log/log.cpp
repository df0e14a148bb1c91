#include "common/log/log.h"

#include <spdlog/pattern_formatter.h>
#include <spdlog/sinks/ringbuffer_sink.h>
#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>

#include <limits>
#include <nlohmann/json.hpp>
#include <utility>

#include "common/base/printable.h"

namespace parray::log {
namespace {

/// Writes the message as a JSON string. Replaces bytes that are not UTF-8.
class JsonMessage final : public spdlog::custom_flag_formatter {
 public:
  void format(const spdlog::details::log_msg& message, const std::tm& /*time*/,
              spdlog::memory_buf_t& out) override {
    const std::string text =
        nlohmann::json(std::string(message.payload.data(), message.payload.size()))
            .dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
    out.append(text.data(), text.data() + text.size());
  }
  [[nodiscard]] std::unique_ptr<custom_flag_formatter> clone() const override {
    return std::make_unique<JsonMessage>();
  }
};

/// Writes the message as a text of one line without control characters: peers and users choose
/// parts of it.
class TextMessage final : public spdlog::custom_flag_formatter {
 public:
  void format(const spdlog::details::log_msg& message, const std::tm& /*time*/,
              spdlog::memory_buf_t& out) override {
    const std::string text = printable({message.payload.data(), message.payload.size()},
                                       std::numeric_limits<std::size_t>::max());
    out.append(text.data(), text.data() + text.size());
  }
  [[nodiscard]] std::unique_ptr<custom_flag_formatter> clone() const override {
    return std::make_unique<TextMessage>();
  }
};

/// Makes a formatter whose pattern writes the message where it has %*.
template <typename Message>
std::unique_ptr<spdlog::pattern_formatter> formatter_of(const char* pattern) {
  auto formatter = std::make_unique<spdlog::pattern_formatter>();
  formatter->add_flag<Message>('*').set_pattern(pattern);
  return formatter;
}

}  // namespace

void LogOptions::add_to(CommandLine& line, const std::string& levels) {
  line.option("--log-level", level, levels)
      .one_of({"debug", "info", "warn", "error"})
      .show_default()
      .group("Output");
  line.option("--log-format", format, "text, or json: one object per line")
      .one_of({"text", "json"})
      .show_default()
      .group("Output");
}

std::shared_ptr<spdlog::logger> make_log(const std::string& name, const LogOptions& options) {
  auto log = spdlog::stderr_color_mt(name);
  log->set_level(spdlog::level::from_str(options.level));
  log->set_formatter(
      options.format == "json"
          ? formatter_of<JsonMessage>(
                R"({"time":"%Y-%m-%dT%H:%M:%S.%f%z","level":"%l","logger":"%n","message":%*})")
          : formatter_of<TextMessage>("[%Y-%m-%d %H:%M:%S.%e] [%n] [%^%l%$] %*"));
  return log;
}

std::function<std::vector<std::string>()> keep_lines(spdlog::logger& log, std::size_t most) {
  const auto sink = std::make_shared<spdlog::sinks::ringbuffer_sink_mt>(most);
  sink->set_formatter(formatter_of<TextMessage>("%Y-%m-%d %H:%M:%S.%e %l: %*"));
  log.sinks().push_back(sink);
  return [sink] {
    std::vector<std::string> lines = sink->last_formatted();
    for (std::string& line : lines) line.erase(line.find_last_not_of("\r\n") + 1);
    return lines;
  };
}

}  // namespace parray::log
