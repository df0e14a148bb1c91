#pragma once

#include <cstddef>

#include "cli/scene_sandbox/limits.h"
#include "cli/scene_sandbox/upload_jobs.h"

namespace parray::scene_sandbox {

/// Reads the scene in the current directory as write_upload_jobs() does, traces a part of its
/// picture for about two seconds on one thread, and writes a forecast to ../forecast: a JSON map
/// with the keys of the answer to POST /api/v1/plan, except those that depend on the queue.
/// `threads`: those of the farm; 0: none, and then `seconds` is null. Of a series, the forecast is
/// that of all frames together, if they are like the first.
///
/// Throws InputError if the scene cannot be read, or the job's target is out of reach.
void write_forecast(const UploadRequest& request, std::size_t threads,
                    const ChildResources& resources);

}  // namespace parray::scene_sandbox
