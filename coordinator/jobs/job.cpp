#include "coordinator/jobs/job.h"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "common/adaptive/passes.h"
#include "common/scene/limits.h"
#include "common/scene/settings.h"

namespace parray::coordinator {

using nlohmann::json;

/// Adds a job's targets and its current error.
static void add_error(json& summary, const Job& job) {
  const RenderSettings& s = job.record.settings;
  if (s.target_error > 0) summary["target_error"] = s.target_error;
  if (s.target_half_width > 0) summary["target_half_width"] = s.target_half_width;
  const ErrorFigures& latest = job.record.course.error;
  if (latest.known() || job.record.state == JobState::done) {
    summary["error"] = error_to_json(latest);
  } else if (job.work && job.work->error_so_far.share > 0) {
    const auto& [error, share] = job.work->error_so_far;
    summary["error_so_far"] = {
        {"rmse", error.rmse}, {"low", error.low}, {"high", error.high}, {"share", share}};
  }
}

/// Returns the share of the work that is not done, by the latest forecast.
double Job::share_left(Time now) const {
  if (record.state == JobState::done) return 0;
  if (!work || !work->plan) return 1 - record.course.progress;
  const double elapsed = work->started == never ? 0 : to_seconds(now - work->clock_began);
  return 1 - share_done(record.settings, *work, elapsed);
}

double Job::progress(Time now) const {
  const double share = 1 - share_left(now);
  const RenderSettings& s = record.settings;
  const bool forecast = s.target_error > 0 || s.target_half_width > 0;
  if (!forecast || record.state == JobState::done || !work || !work->plan) return share;
  // The forecast of a later pass may need more samples. So each pass divides the share that was
  // left at its begin.
  constexpr double most = 0.99;
  const double before = work->pass_progress;
  const auto since = static_cast<double>(work->samples) - static_cast<double>(work->pass_samples);
  const auto needed =
      static_cast<double>(work->expected_samples) - static_cast<double>(work->pass_samples);
  const double of_pass = needed > 0 ? std::clamp(since / needed, 0.0, 1.0) : 0;
  return std::min(std::max(share, before + (1 - before) * of_pass), most);
}

bool Job::samples_known() const {
  const RenderSettings& s = record.settings;
  const bool target = s.target_error > 0 || s.target_half_width > 0;
  return !target || (work && work->plan && work->expected_samples > 0);
}

double Job::samples_left(Time now) const {
  const RenderSettings& s = record.settings;
  const double most = static_cast<double>(s.width) * s.height * s.samples_per_pixel;
  return work && work->plan && work->expected_samples > 0
             ? static_cast<double>(work->expected_samples) * share_left(now)
             : most * share_left(now);
}

double Job::seconds_left(Time now) const {
  const double speed = samples_per_second(now);
  if (speed <= 0) return -1;
  const RenderSettings& s = record.settings;
  const double traced = static_cast<double>(work->samples);
  const double by_samples =
      work->expected_samples > 0
          ? std::max(static_cast<double>(work->expected_samples) - traced, 0.0) / speed
          : -1;
  if (s.time_limit <= 0) return by_samples;
  const double by_time = std::max(s.time_limit - to_seconds(now - work->clock_began), 0.0);
  return by_samples < 0 ? by_time : std::min(by_samples, by_time);
}

std::uint64_t Job::samples() const {
  return work && work->plan ? work->samples : record.course.samples;
}

double Job::samples_a_pixel() const {
  return static_cast<double>(samples()) / static_cast<double>(pixel_count(record.settings));
}

double Job::seconds_taken(Time now) const {
  return record.course.taken + (traced_since == never ? 0 : to_seconds(now - traced_since));
}

void Job::count_time(Time now, bool counts) {
  record.course.taken = seconds_taken(now);
  traced_since = counts ? now : never;
}

bool Job::has_picture() const {
  if (work) return work->plan && work->samples > 0;
  const bool in_store = record.state == JobState::done || record.course.samples > 0;
  return stored ? in_store : picture_bytes > 0;
}

void Job::read_report() {
  const json map = json::parse(record.report, nullptr, false);
  if (!map.is_object()) return;
  record.course.error = error_from_json(map.value("error", json()));
  const json stopped = map.value("stopped_by", json());
  const json samples = map.value("samples", json());
  ended_by = stopped == name_of(StopReason::error)        ? "target_error"
             : stopped == name_of(StopReason::half_width) ? "target_half_width"
             : stopped == name_of(StopReason::time)       ? "time_limit"
                                                          : "samples";
  record.course.samples =
      samples.is_number_unsigned() ? samples.get<std::uint64_t>() : record.course.samples;
  record.course.progress = 1;
}

PassTimes Job::times(Time now) const {
  if (!work || work->started == never) return {};
  const auto since = [now](Time then) { return then == never ? 0 : to_seconds(now - then); };
  PassTimes times = ending_times(record.settings, work->samples,
                                 record.reserved_seconds + since(work->clock_began));
  times.deciding = std::max(times.deciding, work->deciding);
  // Workers build accelerators only in the first pass.
  const double build = work->pass == 0 ? work->facts.build_seconds : 0;
  times.pass = work->pass_began == never ? 0 : std::max(since(work->pass_began) - build, 1e-4);
  return times;
}

std::string_view Job::shown_state() const {
  if (phase == JobPhase::finishing) return "finishing";
  const bool open = record.state == JobState::queued || record.state == JobState::running;
  return name_of(open && !pause_reason.empty() ? JobState::paused : record.state);
}

double Job::samples_per_second(Time now) const {
  if (!begun() || work->samples <= work->samples_before) return 0;
  const double taken = seconds_taken(now) - work->taken_before;
  return taken > 0 ? static_cast<double>(work->samples - work->samples_before) / taken : 0;
}

JobTimes times_of(const Job& job, Time now) {
  const JobCourse& course = job.record.course;
  const auto known = [](double time) { return time > 0 ? std::optional(time) : std::nullopt; };
  JobTimes times{known(course.submitted), known(course.started), {}, {}};
  if (job.ended()) times.finished = known(course.finished);
  if (times.started) times.taken = job.seconds_taken(now);
  return times;
}

void add_times(json& summary, const JobTimes& times) {
  const auto known = [](const std::optional<double>& time) { return time ? json(*time) : json(); };
  summary["submitted"] = known(times.submitted);
  summary["started"] = known(times.started);
  summary["finished"] = known(times.finished);
  summary["seconds_taken"] = known(times.taken);
}

json job_summary(const Job& job, Time now, const std::string& waits_for) {
  const JobRecord& record = job.record;
  const RenderSettings& settings = record.settings;
  const bool limited = settings.samples_per_pixel < limits::max_samples_per_pixel;
  json summary = {{"id", record.id},
                  {"name", record.name},
                  {"user", record.user},
                  {"state", job.shown_state()},
                  {"priority", record.priority},
                  {"progress", job.progress(now)},
                  {"samples_per_second", job.samples_per_second(now)},
                  {"seconds_left", job.seconds_left(now)},
                  {"reason", job.pause_reason.empty() ? record.reason : job.pause_reason},
                  {"waits_for", waits_for},
                  {"flag", record.flag},
                  {"width", settings.width},
                  {"height", settings.height},
                  {"samples_per_pixel",
                   limited || !settings.in_passes() ? json(settings.samples_per_pixel) : json()},
                  {"samples_taken", job.samples_a_pixel()},
                  {"sampler", name_of(settings.sampler)},
                  {"has_picture", job.has_picture()},
                  {"denoise", record.denoise},
                  {"whole", record.state == JobState::done || (job.work && job.work->whole)}};
  add_times(summary, times_of(job, now));
  if (!record.drawing.empty()) summary["drawn"] = true;
  add_error(summary, job);
  if (!record.warning.empty()) summary["warning"] = record.warning;
  if (record.preview_of != 0) summary["preview_of"] = record.preview_of;
  if (!job.ended_by.empty()) summary["ended_by"] = job.ended_by;
  if (record.series_id != 0) {
    summary["series"] = record.series_id;
    summary["frame"] = record.frame;
  }
  return summary;
}

}  // namespace parray::coordinator
