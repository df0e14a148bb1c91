#pragma once

#include "common/image/picture_bytes.h"
#include "coordinator/jobs/job_picture.h"
#include "coordinator/jobs/job_run.h"
#include "coordinator/store/store.h"

namespace parray::coordinator {

/// Makes the picture from the current sums. Pixels without a sample get the colours of others. All
/// half-widths are infinite while any pixel has fewer than two samples. `statistics`: also the
/// numbers of samples and the half-widths, which take longer.
PictureParts parts_so_far(const JobPicture& picture, bool statistics);

/// Makes a run with the results of the job's log, up to the first damaged entry. Leaves the store
/// unchanged. But the run would write further results to `store`, so only read the run's picture.
/// Throws RunError if the store lacks the job's scene.
JobRun run_from_log(Store& store, const JobRecord& record);

}  // namespace parray::coordinator
