#pragma once

#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "coordinator/jobs/job.h"

namespace parray::coordinator {

/// Frames that clients see as one job; each is a job of its own. Sorted by frame; not empty.
using Series = std::vector<const Job*>;

/// Returns whether the series has ended: all submitted frames have ended, and no more will come.
/// More come until all are submitted or some are cancelled.
bool has_ended(const Series& series);

/// Returns the first frame that has not ended. Null: all have.
const Job* first_unfinished(const Series& series);

/// Returns a series' job map of PROTOCOL.md. `waits_for`: what the first unfinished frame lacks.
nlohmann::json series_summary(const Series& series, Time now, const std::string& waits_for);

/// Returns `frame_list` of that map: at most 1000 frames, from the number `from` on.
nlohmann::json frame_list(const Series& series, std::uint32_t from);

}  // namespace parray::coordinator
