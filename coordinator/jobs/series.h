#pragma once

#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "coordinator/jobs/job.h"

namespace parray::coordinator {

/// Frames that people see as one job; each is a job of its own. By number of the frame; not empty.
using Series = std::vector<const Job*>;

/// Whether nothing more will come of it: all frames have been submitted and have ended, or those
/// that were not never will be, since some were cancelled.
bool has_ended(const Series& series);

/// The first frame that has not ended; null: none.
const Job* first_unfinished(const Series& series);

/// The job map of PROTOCOL.md of a whole series; `waits_for` is what its first unfinished frame
/// lacks.
nlohmann::json series_summary(const Series& series, Time now, const std::string& waits_for);

/// `frame_list` of that map: at most 1000 frames, those from this number on.
nlohmann::json frame_list(const Series& series, std::uint32_t from);

}  // namespace parray::coordinator
