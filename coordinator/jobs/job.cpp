#include "coordinator/jobs/job.h"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "common/scene/settings.h"
#include "coordinator/jobs/report.h"

namespace parray::coordinator {

using nlohmann::json;

namespace {

/// Adds a job's targets and its current error.
void add_error(json& summary, const Job& job) {
  const RenderSettings& s = job.record.settings;
  if (s.target_error > 0) {
    summary["target_error"] = s.target_error;
  }
  if (s.target_half_width > 0) {
    summary["target_half_width"] = s.target_half_width;
  }
  if (job.error.known()) {
    summary["error"] = error_to_json(job.error);
  }
}

}  // namespace

double Job::progress(Time now) const {
  if (record.state == JobState::done) {
    return 1;
  }
  if (!work || !work->plan) {
    return kept_progress;
  }
  const double elapsed = work->started == never ? 0 : to_seconds(now - work->clock_began);
  return share_done(record.settings, *work, elapsed);
}

double Job::samples_left(Time now) const {
  const RenderSettings& s = record.settings;
  const double most = static_cast<double>(s.width) * s.height * s.samples_per_pixel;
  return work && work->plan && work->expected_samples > 0
             ? static_cast<double>(work->expected_samples) * (1 - progress(now))
             : most * (1 - progress(now));
}

PassTimes Job::times(Time now) const {
  if (!work || work->started == never) {
    return {};
  }
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
  if (phase == JobPhase::finishing) {
    return "finishing";
  }
  const bool open = record.state == JobState::queued || record.state == JobState::running;
  return name_of(open && !pause_reason.empty() ? JobState::paused : record.state);
}

double Job::samples_per_second(Time now) const {
  const bool begun = work && work->started != never && now > work->started;
  return begun ? static_cast<double>(work->samples) / to_seconds(now - work->started) : 0;
}

json job_summary(const Job& job, Time now, const std::string& waits_for) {
  const JobRecord& record = job.record;
  json summary = {{"id", record.id},
                  {"name", record.name},
                  {"user", record.user},
                  {"state", job.shown_state()},
                  {"priority", record.priority},
                  {"progress", job.progress(now)},
                  {"samples_per_second", job.samples_per_second(now)},
                  {"seconds_left", -1.0},
                  {"reason", job.pause_reason.empty() ? record.reason : job.pause_reason},
                  {"waits_for", waits_for},
                  {"flag", record.flag},
                  {"width", record.settings->width},
                  {"height", record.settings->height},
                  {"samples_per_pixel", record.settings->samples_per_pixel},
                  {"sampler", name_of(record.settings->sampler)},
                  {"denoise", record.denoise},
                  {"whole", record.state == JobState::done || (job.work && job.work->whole)}};
  if (!record.drawing.empty()) summary["drawn"] = true;
  add_error(summary, job);
  if (record.series_id != 0) {
    summary["series"] = record.series_id;
    summary["frame"] = record.frame;
  }
  const double progress = summary["progress"];
  if (job.samples_per_second(now) > 0) {
    const double elapsed = to_seconds(now - job.work->started);
    summary["seconds_left"] = progress > 0 ? elapsed * (1 - progress) / progress : -1;
  }
  return summary;
}

}  // namespace parray::coordinator
