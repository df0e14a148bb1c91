#pragma once

#include <nlohmann/json_fwd.hpp>
#include <optional>

#include "coordinator/jobs/series.h"
#include "proto/clock.h"

namespace parray::coordinator {

/// When a job or a series was submitted, started and ended, in seconds since 1970. Nothing:
/// unknown, or it has not happened.
struct JobTimes {
  std::optional<double> submitted;
  std::optional<double> started;   ///< its first lease
  std::optional<double> finished;  ///< only if it has ended
  /// Seconds from the start to the end or to now, without pauses. For a series: seconds from the
  /// first start of a frame to the latest time at which a frame was traced, pauses included.
  std::optional<double> taken;
};

/// Return the times of a job or of a series. The second takes linear time in the number of frames.
JobTimes times_of(const Job& job, Time now);
JobTimes times_of(const Series& series, Time now);
/// Adds the times to a job map. Unknown times are null.
void add_times(nlohmann::json& summary, const JobTimes& times);

}  // namespace parray::coordinator
