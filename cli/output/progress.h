#pragma once

#include <functional>
#include <optional>
#include <ostream>
#include <string>
#include <string_view>

#include "cli/farm/client.h"

namespace parray::output {

/// How a command shows the progress of a job.
enum class ProgressStyle {
  none,
  lines,  ///< a line every 10 s, and one when the job has ended: for logs
  bar,    ///< one line, redrawn at most five times a second
  json    ///< for programs: a line of progress_json() at most five times a second
};

/// Returns `none` if `quiet`, otherwise the style for `wanted`: "bar", "lines" or "json". For any
/// other text, returns `bar` if stderr is a terminal that can return to the start of a line,
/// otherwise `lines`.
ProgressStyle progress_style(bool quiet, std::string_view wanted = {});

/// Returns the number of columns of the terminal of stderr. Returns 80 if it is unknown.
std::size_t terminal_columns();

/// Returns the progress of a series: "3/10 frames".
std::string frames_text(const JobStatus& job);

/// Returns "[#####     ]  43.1 %  3.14 M samples/s  error 0.021 of 0.01  12 s left" with at most
/// `columns` characters. 0.021 is the present error, and 0.01 the target. A small width first
/// shortens the bar, then omits it. Plain text without colours and control characters.
std::string bar_text(const JobStatus& job, std::size_t columns);

/// Returns one line of JSON, without a line end. It has the members of `show --json` that change
/// while a job runs: `state`, `progress`, `samples_per_second`, `seconds_left`, `waits_for`, and
/// `error`, the estimates of error_to_json(). For a series also `frames` and `frames_done`.
/// `seconds_left` is null if it is unknown, where `show --json` has -1; after the end, it is 0.
std::string progress_json(const JobStatus& job);

/// Shows the progress of a job. Uses no colours, so NO_COLOR does not matter. Not thread-safe.
class Progress {
 public:
  /// Writes to `out`, which must outlive the object. `columns` returns the current width of the
  /// terminal.
  Progress(ProgressStyle style, std::ostream& out, std::function<std::size_t()> columns);
  /// Ends the line of a bar.
  ~Progress();
  Progress& operator=(Progress&&) = delete;

  /// Records the state of a job. Shows it if it is time, and always when the job has ended.
  void show(Time now, const JobStatus& reported);
  /// Ends the line of a bar, so that other output can follow.
  void make_way();

 private:
  JobStatus between_leases(Time now, const JobStatus& job);
  void draw_bar(const JobStatus& job);

  const ProgressStyle style_;
  std::ostream& out_;
  const std::function<std::size_t()> columns_;
  std::optional<Time> next_;  ///< when to show the job again
  JobStatus last_;            ///< state when progress, state or waits_for last changed
  Time last_growth_{};
  std::size_t drawn_ = 0;  ///< current length of the bar's line
};

}  // namespace parray::output
