#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "common/log/logger.h"
#include "proto/clock.h"

namespace parray::coordinator {

/// Limits the log lines that strangers can cause. Counts the lines that it drops.
class LogBudget {
 public:
  /// `most`: lines per ten seconds.
  explicit LogBudget(std::shared_ptr<spdlog::logger> log, std::uint32_t most = 20)
      : log_(std::move(log)), most_(most) {}

  void info(Time now, const std::string& line) { write(now, spdlog::level::info, line); }
  void warn(Time now, const std::string& line) { write(now, spdlog::level::warn, line); }

 private:
  void write(Time now, spdlog::level::level_enum level, const std::string& line) {
    constexpr Time period = seconds(10);
    if (now - began_ >= period) {
      if (dropped_ > 0) log_->log(level, "dropped {} more lines like these", dropped_);
      began_ = now;
      lines_ = 0;
      dropped_ = 0;
    }
    if (lines_ < most_) {
      ++lines_;
      log_->log(level, line);
    } else {
      ++dropped_;
    }
  }

  std::shared_ptr<spdlog::logger> log_;
  std::uint32_t most_;
  Time began_{};
  std::uint32_t lines_ = 0;
  std::uint64_t dropped_ = 0;
};

}  // namespace parray::coordinator
