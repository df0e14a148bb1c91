#pragma once

#include <optional>

#include "coordinator/jobs/series.h"

namespace parray::coordinator {

/// When a job or a series was submitted, begun and ended, in seconds since 1970, from its history.
struct JobTimes {
  std::optional<double> submitted;
  std::optional<double> begun;     ///< its first lease
  std::optional<double> finished;  ///< only if it has ended

  /// Returns the seconds from the first lease to the end, or to `now` (seconds since 1970).
  [[nodiscard]] std::optional<double> taken(double now) const;
};

JobTimes times_of(const JobRecord& job);
/// Takes linear time in the number of frames.
JobTimes times_of(const Series& series);

}  // namespace parray::coordinator
