#include "coordinator/jobs/job_times.h"

#include <algorithm>

namespace parray::coordinator {

std::optional<double> JobTimes::taken(double now) const {
  return begun ? std::optional(std::max(0.0, finished.value_or(now) - *begun)) : std::nullopt;
}

JobTimes times_of(const JobRecord& job) {
  JobTimes times;
  if (job.events.empty()) {
    return times;
  }
  times.submitted = job.events.front().at;
  const auto begun = std::ranges::find(job.events, "begun", &JobEvent::what);
  if (begun != job.events.end()) {
    times.begun = begun->at;
  }
  if (!is_unfinished(job.state)) {
    times.finished = job.events.back().at;
  }
  return times;
}

JobTimes times_of(const Series& series) {
  const bool ended = has_ended(series);
  JobTimes times;
  const auto take = [](std::optional<double>& kept, const std::optional<double>& next,
                       auto choose) {
    if (next) kept = kept ? choose(*kept, *next) : *next;
  };
  const auto least = [](double a, double b) { return std::min(a, b); };
  const auto most = [](double a, double b) { return std::max(a, b); };
  for (const Job* job : series) {
    const JobTimes frame = times_of(job->record);
    take(times.submitted, frame.submitted, least);
    take(times.begun, frame.begun, least);
    if (ended) take(times.finished, frame.finished, most);
  }
  return times;
}

}  // namespace parray::coordinator
