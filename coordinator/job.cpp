#include "coordinator/job.h"

#include <algorithm>
#include <nlohmann/json.hpp>

namespace parray {

using nlohmann::json;

double Job::progress(Time now) const {
  if (record.state == JobState::done) {
    return 1;
  }
  if (!work || !work->plan) {
    return 0;
  }
  const RenderSettings& s = record.settings;
  if (!s.in_passes()) {
    return static_cast<double>(work->cells) / static_cast<double>(work->plan->cells());
  }
  double share = work->expected_samples == 0 ? 0
                                             : static_cast<double>(work->samples) /
                                                   static_cast<double>(work->expected_samples);
  if (s.time_limit > 0 && work->started != never) {
    share = std::max(share, to_seconds(now - work->started) / s.time_limit);
  }
  return std::min(share, 1.0);
}

double Job::samples_left(Time now) const {
  const RenderSettings& s = record.settings;
  const double most = static_cast<double>(s.width) * s.height * s.samples_per_pixel;
  return work && work->plan && work->expected_samples > 0
             ? static_cast<double>(work->expected_samples) * (1 - progress(now))
             : most * (1 - progress(now));
}

double Job::ended_seconds(Time now, double wall) const {
  if (ended_at != never) {
    return to_seconds(now - ended_at);
  }
  return record.events.empty() ? 0 : wall - record.events.back().at;
}

PassTimes Job::times(Time now) const {
  if (!work || work->started == never) {
    return {};
  }
  return {record.load_seconds + to_seconds(now - work->started),
          work->pass_began == never ? 0 : to_seconds(now - work->pass_began)};
}

/// As `show` names it: what the record keeps, and what comes and goes.
static std::string_view state_name(const Job& job) {
  if (job.phase == JobPhase::finishing) {
    return "finishing";
  }
  const bool open = job.record.state == JobState::queued || job.record.state == JobState::running;
  return open && !job.pause_reason.empty() ? name_of(JobState::paused) : name_of(job.record.state);
}

json job_summary(const Job& job, Time now, const std::string& waits_for) {
  const JobRecord& record = job.record;
  json summary = {{"id", record.id},
                  {"name", record.name},
                  {"user", record.user},
                  {"state", state_name(job)},
                  {"priority", record.priority},
                  {"progress", job.progress(now)},
                  {"samples_per_second", 0.0},
                  {"seconds_left", -1.0},
                  {"reason", job.pause_reason.empty() ? record.reason : job.pause_reason},
                  {"waits_for", waits_for},
                  {"flag", record.flag},
                  {"width", record.settings.width},
                  {"height", record.settings.height},
                  {"samples_per_pixel", record.settings.samples_per_pixel},
                  {"sampler", name_of(record.settings.sampler)},
                  {"whole", record.state == JobState::done || (job.work && job.work->whole)}};
  if (!job.work || job.work->started == never || job.work->samples == 0) {
    return summary;
  }
  const double elapsed = to_seconds(now - job.work->started);
  const double progress = summary["progress"];
  if (elapsed > 0) {
    summary["samples_per_second"] = static_cast<double>(job.work->samples) / elapsed;
    summary["seconds_left"] = progress > 0 ? elapsed * (1 - progress) / progress : -1;
  }
  return summary;
}

}  // namespace parray
