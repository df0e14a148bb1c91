#pragma once

#include <nlohmann/json_fwd.hpp>

#include "coordinator/loop/farm.h"

namespace parray::coordinator {

/// Returns the worker map of PROTOCOL.md: what clients see of one worker.
nlohmann::json worker_summary(const Farm& farm, const WorkerRecord& worker, Time now);

/// Returns the worker map with `history` and `recent_failures`.
nlohmann::json worker_details(const Farm& farm, const WorkerRecord& worker, Time now);

}  // namespace parray::coordinator
