#include "coordinator/jobs/series.h"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>

#include "common/base/printable.h"

namespace parray::coordinator {
namespace {

using nlohmann::json;

/// Number of frames in each state, and sums over all frames.
struct Totals {
  std::uint32_t unfinished = 0;
  std::uint32_t paused = 0;
  std::uint32_t begun = 0;
  std::uint32_t done = 0;
  std::uint32_t failed = 0;
  std::uint32_t cancelled = 0;
  std::uint32_t missing = 0;  ///< not submitted yet
  double progress = 0;        ///< summed
  double samples_left = 0;
  double samples_a_pixel = 0;
  double samples_per_second = 0;
};

/// Returns the number of frames that the series will have.
std::uint32_t all_frames(const Series& series) {
  std::uint32_t frames = 0;
  for (const Job* job : series) frames = std::max(frames, job->record.frames);
  return std::max(frames, static_cast<std::uint32_t>(series.size()));
}

Totals totals_of(const Series& series, Time now) {
  Totals totals;
  totals.missing = all_frames(series) - static_cast<std::uint32_t>(series.size());
  for (const Job* job : series) {
    const JobState state = job->record.state;
    totals.unfinished += job->ended() ? 0 : 1;
    totals.paused += state == JobState::paused ? 1 : 0;
    totals.done += state == JobState::done ? 1 : 0;
    totals.failed += state == JobState::failed ? 1 : 0;
    totals.cancelled += state == JobState::cancelled ? 1 : 0;
    totals.progress += job->progress(now);
    totals.samples_left += job->ended() ? 0 : job->samples_left(now);
    totals.samples_a_pixel += job->samples_a_pixel();
    totals.begun += job->ended() || job->begun() ? 1 : 0;
    // Two frames may be traced at a time; each speed is that of all workers.
    totals.samples_per_second = std::max(totals.samples_per_second, job->samples_per_second(now));
  }
  totals.samples_left *=
      totals.unfinished > 0 ? 1 + static_cast<double>(totals.missing) / totals.unfinished : 0;
  return totals;
}

JobState state_of(const Totals& totals) {
  if (totals.unfinished > 0 && totals.unfinished == totals.paused) return JobState::paused;
  if (totals.unfinished > 0) return totals.begun > 0 ? JobState::running : JobState::queued;
  if (totals.cancelled > 0) return JobState::cancelled;
  if (totals.missing > 0) return JobState::queued;
  return totals.failed > 0 ? JobState::failed : JobState::done;
}

const Job& first_in(const Series& series, JobState state) {
  return **std::ranges::find_if(series, [&](const Job* j) { return j->record.state == state; });
}

/// Returns why frames are not rendered. Empty: all are, or were.
std::string reason_of(const Series& series, const Totals& totals) {
  if (totals.failed > 0) {
    const JobRecord& first = first_in(series, JobState::failed).record;
    return fmt::format("{} of {} frames failed: first frame {}: {}", totals.failed,
                       series.size() + totals.missing, first.frame, first.reason);
  }
  if (totals.cancelled > 0) {
    return fmt::format("{} of {} frames were cancelled", totals.cancelled,
                       series.size() + totals.missing);
  }
  return totals.paused > 0 && totals.paused == totals.unfinished
             ? first_in(series, JobState::paused).record.reason
             : "";
}

/// Returns the first flag, with its frame. Empty: no frame has one.
std::string flag_of(const Series& series) {
  const auto found =
      std::ranges::find_if(series, [](const Job* j) { return !j->record.flag.empty(); });
  return found == series.end()
             ? ""
             : fmt::format("frame {}: {}", (*found)->record.frame, (*found)->record.flag);
}

/// Several frames of a series that had the same event, because of one request of a client.
struct SameEvents {
  double at = 0;
  std::size_t frames = 0;
  std::uint32_t frame = 0;  ///< the first
};

}  // namespace

bool has_ended(const Series& series) {
  if (first_unfinished(series) != nullptr) return false;
  return series.size() == all_frames(series) || std::ranges::any_of(series, [](const Job* j) {
           return j->record.state == JobState::cancelled;
         });
}

const Job* first_unfinished(const Series& series) {
  const auto found = std::ranges::find_if(series, [](const Job* j) { return !j->ended(); });
  return found == series.end() ? nullptr : *found;
}

JobTimes times_of(const Series& series, Time now) {
  JobTimes times;
  double latest = 0;  // the latest time at which a frame was traced
  const auto take_least = [](std::optional<double>& kept, const std::optional<double>& next) {
    if (next) kept = std::min(kept.value_or(*next), *next);
  };
  for (const Job* job : series) {
    const JobTimes frame = times_of(*job, now);
    take_least(times.submitted, frame.submitted);
    take_least(times.started, frame.started);
    if (frame.started) {
      latest = std::max(latest, frame.finished.value_or(*frame.started + *frame.taken));
    }
  }
  if (times.started) {
    times.taken = latest - *times.started;
    times.finished = has_ended(series) ? std::optional(latest) : std::nullopt;
  }
  return times;
}

json series_summary(const Series& series, Time now, const std::string& waits_for) {
  const JobRecord& first = series.front()->record;
  const Totals totals = totals_of(series, now);
  const std::uint32_t frames = static_cast<std::uint32_t>(series.size()) + totals.missing;
  const JobState state = state_of(totals);
  json summary = job_summary(*series.front(), now, waits_for);
  summary.erase("frame");
  summary.erase("error");  // each frame has its own
  summary.erase("error_so_far");
  summary["id"] = first.series_id;
  summary["series"] = first.series;
  summary["frames"] = frames;
  summary["frames_done"] = totals.done;
  summary["state"] = name_of(state);
  summary["priority"] = priority_of(series);
  summary["progress"] = totals.progress / frames;
  summary["samples_per_second"] = totals.samples_per_second;
  summary["seconds_left"] =
      totals.samples_per_second > 0 ? totals.samples_left / totals.samples_per_second : -1;
  summary["reason"] = reason_of(series, totals);
  summary["flag"] = flag_of(series);
  summary["whole"] = false;
  add_times(summary, times_of(series, now));
  summary["samples_taken"] = totals.samples_a_pixel / static_cast<double>(series.size());
  summary["has_picture"] = false;  // each frame has its own
  summary.erase("ended_by");
  if (totals.unfinished == 0 && state == JobState::queued) {
    summary["waits_for"] = fmt::format(
        "{} of {} frames: repeat the same parray submit to submit them", totals.missing, frames);
  }
  return summary;
}

JobState state_of(const Series& series, Time now) { return state_of(totals_of(series, now)); }

double progress_of(const Series& series, Time now) {
  return totals_of(series, now).progress / all_frames(series);
}

std::uint32_t priority_of(const Series& series) {
  const Job* open = first_unfinished(series);
  return (open != nullptr ? *open : *series.front()).record.priority;
}

json frame_list(const Series& series, Time now, std::uint32_t from) {
  constexpr std::size_t most = 1000;
  constexpr std::size_t longest_reason = 200;
  json list = json::array();
  for (const Job* job : series) {
    if (job->record.frame >= from && list.size() < most) {
      const auto taken = times_of(*job, now).taken;
      const ErrorFigures& error = job->record.course.error;
      list.push_back({{"frame", job->record.frame},
                      {"job", job->record.id},
                      {"state", job->shown_state()},
                      {"reason", printable(job->record.reason, longest_reason)},
                      {"progress", job->progress(now)},
                      {"seconds", taken ? json(*taken) : json()},
                      {"rmse", error.known() ? json(error.rmse) : json()},
                      {"has_picture", job->has_picture()}});
    }
  }
  return list;
}

std::vector<JobEvent> events_of(const Series& series) {
  constexpr double at_once = 5;  // seconds within which one action reaches all frames
  std::optional<JobEvent> submitted;
  std::optional<JobEvent> begun;
  const auto keep_earliest = [](std::optional<JobEvent>& kept, const JobEvent& event) {
    if (!kept || event.at < kept->at) kept = event;
  };
  std::map<std::pair<std::string_view, long>, SameEvents> others;
  for (const Job* job : series) {
    for (const JobEvent& event : job->record.events) {
      if (event.what == "done") continue;
      if (event.what.starts_with("submitted")) {
        keep_earliest(submitted, event);
      } else if (event.what == "started") {
        keep_earliest(begun, event);
      } else {
        const auto [entry, is_new] =
            others.try_emplace({event.what, std::lround(event.at / at_once)},
                               SameEvents{event.at, 0, job->record.frame});
        ++entry->second.frames;
        entry->second.at = std::min(entry->second.at, event.at);
      }
    }
  }
  std::vector<JobEvent> all;
  for (const auto& first : {submitted, begun}) {
    if (first) all.push_back(*first);
  }
  for (const auto& [key, same] : others) {
    const bool single = same.frames == 1 && series.size() > 1;
    all.push_back({same.at, single ? fmt::format("frame {}: {}", same.frame, key.first)
                                   : std::string(key.first)});
  }
  std::ranges::stable_sort(all, {}, &JobEvent::at);
  JobRecord shortened;  // keeps the first and the latest
  for (JobEvent& event : all) shortened.note(event.at, std::move(event.what));
  return shortened.events;
}

}  // namespace parray::coordinator
