#include "coordinator/jobs/job_times.h"

#include <algorithm>
#include <nlohmann/json.hpp>

namespace parray::coordinator {

JobTimes times_of(const Job& job, Time now) {
  const JobCourse& course = job.record.course;
  const auto known = [](double time) { return time > 0 ? std::optional(time) : std::nullopt; };
  JobTimes times{known(course.submitted), known(course.started), {}, {}};
  if (job.ended()) times.finished = known(course.finished);
  if (times.started) times.taken = job.seconds_taken(now);
  return times;
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

void add_times(nlohmann::json& summary, const JobTimes& times) {
  const auto known = [](const std::optional<double>& time) {
    return time ? nlohmann::json(*time) : nlohmann::json();
  };
  summary["submitted"] = known(times.submitted);
  summary["started"] = known(times.started);
  summary["finished"] = known(times.finished);
  summary["seconds_taken"] = known(times.taken);
}

}  // namespace parray::coordinator
