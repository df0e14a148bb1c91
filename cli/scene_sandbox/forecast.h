#pragma once

#include <cstddef>

#include "cli/scene_sandbox/limits.h"
#include "cli/scene_sandbox/upload_jobs.h"

namespace parray::scene_sandbox {

/// Confines this process (limits.h). Reads the scene in the current directory as first_submission()
/// does, traces a part of its picture for about two seconds on one thread, and writes a forecast to
/// ../forecast: a JSON map with the keys of the answer to POST /api/v1/plan, except those that
/// depend on the queue. `threads`: number of threads of all workers; with 0, `seconds` is null. The
/// times of a series are those of all frames together; the forecast assumes that all frames are
/// like the first one.
///
/// Throws InputError if the scene cannot be read, or the job's target is out of reach. Throws
/// RunError if the process cannot be confined, or the forecast cannot be written.
void write_forecast(const UploadRequest& request, std::size_t threads,
                    const ChildResources& resources);

}  // namespace parray::scene_sandbox
