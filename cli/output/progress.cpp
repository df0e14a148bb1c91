#include "cli/output/progress.h"

#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <nlohmann/json.hpp>
#include <string_view>
#include <utility>

#include "cli/output/text.h"
#include "common/base/printable.h"
#include "coordinator/jobs/report.h"

namespace parray::output {
namespace {

constexpr Time bar_interval = milliseconds(200);
constexpr Time line_interval = seconds(10);

std::string percent_text(double fraction) {
  // Rounds down, so that 100 % means the end.
  const double tenths = std::floor(1000 * std::clamp(fraction, 0.0, 1.0));
  return formatted("%5.1f %%", tenths / 10);
}

/// Returns the text after the bar.
std::string facts(const JobStatus& job) {
  std::string text = percent_text(job.progress);
  if (job.frames > 0) text += "  " + frames_text(job);
  if (job.ended()) return text + "  " + job.state;
  if (!job.waits_for.empty()) return text + "  waits for: " + printable(job.waits_for, 200);
  if (job.state == "finishing" || job.state == "paused" || job.state == "reading") {
    text += "  " + job.state;
  }
  if (job.samples_per_second > 0) text += "  " + with_unit(job.samples_per_second, "samples/s");
  if (const std::string target = target_text(job); !target.empty()) text += "  " + target;
  if (job.seconds_left >= 0) text += "  " + duration_text(job.seconds_left) + " left";
  return text;
}

}  // namespace

std::string frames_text(const JobStatus& job) {
  return std::to_string(job.frames_done) + "/" + std::to_string(job.frames) + " frames";
}

ProgressStyle progress_style(bool quiet, std::string_view wanted) {
  if (quiet) return ProgressStyle::none;
  if (wanted == "json") return ProgressStyle::json;
  if (wanted == "bar") return ProgressStyle::bar;
  if (wanted == "lines") return ProgressStyle::lines;
  // NOLINTNEXTLINE(concurrency-mt-unsafe): nothing here changes the environment
  const char* const terminal = std::getenv("TERM");
  const bool dumb = terminal == nullptr || std::string_view(terminal) == "dumb";
  return isatty(STDERR_FILENO) != 0 && !dumb ? ProgressStyle::bar : ProgressStyle::lines;
}

std::size_t terminal_columns() {
  winsize size{};
  const bool known = ioctl(STDERR_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 0;
  return known ? size.ws_col : 80;
}

std::string bar_text(const JobStatus& job, std::size_t columns) {
  constexpr std::size_t longest_bar = 30;
  constexpr std::size_t shortest_bar = 5;
  const std::string text = facts(job);
  const std::size_t frame = std::string_view("[] ").size();
  if (columns < text.size() + frame + shortest_bar) return text.substr(0, columns);
  const std::size_t length = std::min(columns - text.size() - frame, longest_bar);
  const auto filled =
      static_cast<std::size_t>(static_cast<double>(length) * std::clamp(job.progress, 0.0, 1.0));
  return "[" + std::string(filled, '#') + std::string(length - filled, ' ') + "] " + text;
}

std::string progress_json(const JobStatus& job) {
  const bool known = job.ended() || job.seconds_left >= 0;
  const double seconds_left = job.ended() ? 0 : job.seconds_left;
  nlohmann::json map = {{"state", job.state},
                        {"progress", job.progress},
                        {"samples_per_second", job.samples_per_second},
                        {"seconds_left", known ? nlohmann::json(seconds_left) : nullptr},
                        {"waits_for", job.waits_for},
                        {"error", error_to_json(job.error)}};
  if (job.frames > 0) {
    map["frames"] = job.frames;
    map["frames_done"] = job.frames_done;
  }
  return map.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

Progress::Progress(ProgressStyle style, std::ostream& out, std::function<std::size_t()> columns)
    : style_(style), out_(out), columns_(std::move(columns)) {}

Progress::~Progress() { make_way(); }

void Progress::make_way() {
  if (drawn_ > 0) out_ << '\n' << std::flush;
  drawn_ = 0;
}

/// Returns the state to show between two leases. Progress grows only when a lease ends. Until then,
/// the speed stays constant and the remaining time decreases.
JobStatus Progress::between_leases(Time now, const JobStatus& job) {
  if (job.progress != last_.progress || job.state != last_.state ||
      job.frames_done != last_.frames_done || job.waits_for != last_.waits_for) {
    last_ = job;
    last_growth_ = now;
    return job;
  }
  JobStatus shown = last_;
  if (shown.seconds_left >= 0) {
    shown.seconds_left = std::max(shown.seconds_left - to_seconds(now - last_growth_), 0.0);
  }
  return shown;
}

void Progress::show(Time now, const JobStatus& reported) {
  const JobStatus job = between_leases(now, reported);
  const Time interval = style_ == ProgressStyle::lines ? line_interval : bar_interval;
  // A log does not need a line before the first progress.
  if (!next_) next_ = style_ == ProgressStyle::lines ? now + interval : now;
  if (style_ == ProgressStyle::none || (now < *next_ && !job.ended())) return;
  next_ = now + interval;
  if (style_ == ProgressStyle::bar) return draw_bar(job);
  const bool json = style_ == ProgressStyle::json;
  out_ << (json ? progress_json(job) : printable(job.name) + ": " + facts(job)) + "\n"
       << std::flush;
}

void Progress::draw_bar(const JobStatus& job) {
  // Leaves the last column free, because a cursor beyond it would begin a new line.
  const std::size_t room = std::max<std::size_t>(columns_(), 2) - 1;
  std::string line = bar_text(job, room);
  const std::size_t length = line.size();
  const std::size_t previous = std::min(drawn_, room);
  if (length < previous) line.append(previous - length, ' ');  // covers the previous line
  line.insert(line.begin(), '\r');
  out_ << line << std::flush;
  drawn_ = length;
}

}  // namespace parray::output
