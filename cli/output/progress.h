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

/// `wanted`: "bar", "lines" or "json". Empty: a bar on a terminal that can return to the start of a
/// line, otherwise lines.
ProgressStyle progress_style(bool quiet, std::string_view wanted = {});

/// Number of columns of the terminal behind stderr; 80 if unknown.
std::size_t terminal_columns();

/// The frames of a series: "3/10 frames".
std::string frames_text(const JobStatus& job);

/// "[#####     ]  43.1 %  3.14 M samples/s  error 0.021 of 0.01  12 s left", at most `columns`
/// long: the bar shrinks, then goes. Plain text: no colours, no control characters.
std::string bar_text(const JobStatus& job, std::size_t columns);

/// One line of JSON with the members of `show --json` that change: `state`, `progress`,
/// `samples_per_second`, `seconds_left`, `waits_for`, `error`; for a series also `frames` and
/// `frames_done`.
std::string progress_json(const JobStatus& job);

/// Shows the progress of a job. Uses no colours, so that NO_COLOR does not matter. Not thread-safe.
class Progress {
 public:
  /// Writes to `out`, which must outlive the object. `columns` returns the current width of the
  /// terminal.
  Progress(ProgressStyle style, std::ostream& out, std::function<std::size_t()> columns);
  /// Ends the line of a bar.
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  /// Notes the state of a job. Shows it if it is time, and always when the job has ended.
  void show(Time now, const JobStatus& reported);
  /// Ends the line of a bar before other output.
  void make_way();

 private:
  JobStatus between_leases(Time now, const JobStatus& job);
  void draw_bar(const JobStatus& job);

  const ProgressStyle style_;
  std::ostream& out_;
  const std::function<std::size_t()> columns_;
  Time next_{};
  JobStatus last_;  ///< state when the progress last grew
  Time last_growth_{};
  bool started_ = false;
  std::size_t drawn_ = 0;  ///< current length of the bar's line
};

}  // namespace parray::output
