#pragma once

#include "common/image/picture_bytes.h"
#include "coordinator/jobs/job_picture.h"
#include "coordinator/jobs/job_run.h"
#include "coordinator/store/store.h"

namespace parray::coordinator {

/// Makes the picture from the current sums. Pixels without a sample are filled; their half-widths
/// are infinite. `statistics`: also the numbers of samples and the half-widths, which take longer.
PictureParts parts_so_far(const JobPicture& picture, bool statistics);

/// Makes a run with the results of the job's log, up to the first damaged entry. Does not change
/// the store. Throws RunError if the store lacks the job's scene.
JobRun run_from_log(Store& store, const JobRecord& record);

}  // namespace parray::coordinator
