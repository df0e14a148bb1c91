#pragma once

#include <functional>
#include <ostream>
#include <string>
#include <string_view>

#include "cli/farm/client.h"

namespace parray::output {

enum class ProgressStyle {
  none,
  lines,  ///< a line every 10 s, and the last: for logs
  bar,    ///< one line, redrawn
  json    ///< for programs: progress_json(), a line each time that `bar` would be drawn
};

/// `wanted` is "bar", "lines" or "json"; empty: what suits stderr, a bar on a terminal that can go
/// back to the start of a line, else lines.
ProgressStyle progress_style(bool quiet, std::string_view wanted = {});

/// Columns of the terminal behind stderr; 80 if that is unknown.
std::size_t terminal_columns();

/// "3/10 frames" of a series.
std::string frames_text(const JobStatus& job);

/// "[#####     ]  43.1 %  3.14 M samples/s  error 0.021 of 0.01  12 s left", at most `columns`
/// long: the bar shrinks, then goes. Plain text: no colours, no control characters.
std::string bar_text(const JobStatus& job, std::size_t columns);

/// One line of JSON with those members of `show --json` that change: `state`, `progress`,
/// `samples_per_second`, `seconds_left`, `waits_for`, `error`; of a series also `frames` and
/// `frames_done`.
std::string progress_json(const JobStatus& job);

/// Tells people how far a job is. Never colours, so NO_COLOR has nothing to ask for. One thread.
class Progress {
 public:
  /// Writes to `out`, which must outlive the object. `columns` says how wide the terminal is now:
  /// people change that.
  Progress(ProgressStyle style, std::ostream& out, std::function<std::size_t()> columns);
  /// Ends a bar's line, so that whatever comes next starts its own.
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  /// Takes note of a job's state; shows it when it is time to, and always when the job has ended.
  void show(Time now, const JobStatus& reported);
  /// Ends a bar's line: something else is to be printed.
  void make_way();

 private:
  JobStatus between_leases(Time now, const JobStatus& job);
  void draw_bar(const JobStatus& job);

  const ProgressStyle style_;
  std::ostream& out_;
  const std::function<std::size_t()> columns_;
  Time next_{};
  JobStatus last_;  ///< as it was when its progress last grew
  Time last_growth_{};
  bool started_ = false;
  std::size_t drawn_ = 0;  ///< length of the bar's line as it stands
};

}  // namespace parray::output
