#pragma once

#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "coordinator/jobs/job.h"

namespace parray::coordinator {

/// Frames that clients see as one job; each is a job of its own. Sorted by frame; not empty.
using Series = std::vector<const Job*>;

/// Returns whether the series has ended: all submitted frames have ended, and no more frames are
/// expected, because all frames were submitted or a frame was cancelled.
bool has_ended(const Series& series);

/// Returns the first frame that has not ended. Null: all have.
const Job* first_unfinished(const Series& series);

/// Returns the job map of PROTOCOL.md of a series. `waits_for`: what its first unfinished frame
/// waits for; empty: nothing.
nlohmann::json series_summary(const Series& series, Time now, const std::string& waits_for);

/// Return values that the job map of the series contains, in linear time in the number of frames.
JobTimes times_of(const Series& series, Time now);
JobState state_of(const Series& series, Time now);
double progress_of(const Series& series, Time now);
/// Returns the priority of the first unfinished frame, or of the first frame if all have ended.
std::uint32_t priority_of(const Series& series);

/// Returns `frame_list` of that map: at most 1000 frames, from the number `from` on.
nlohmann::json frame_list(const Series& series, Time now, std::uint32_t from);

/// Returns the history of a series, oldest first: its first submit and first lease, what clients
/// did to the series, and what happened to single frames, except that they began and ended well. At
/// most 64 events: the first 16 and the latest.
std::vector<JobEvent> events_of(const Series& series);

}  // namespace parray::coordinator
