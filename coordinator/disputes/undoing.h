#pragma once

#include <optional>

#include "coordinator/disputes/convictions.h"
#include "coordinator/jobs/job_picture.h"
#include "coordinator/store/store.h"

namespace parray::coordinator {

/// The convictions that a state keeps. Throws RunError when its note of workers is damaged.
Convictions kept_convictions(Store& store);

/// Sets back what a convicted machine has traced or checked: in the picture, in the job's rows and
/// in its record, which it puts into the store. Returns what was set back; nothing: the picture
/// does not rely on the machine. `at`: seconds since 1970. `store` may be null.
std::optional<JobPicture::Retraction> undo(JobPicture& picture, Store* store, JobRecord& record,
                                           const Conviction& conviction, double at);

}  // namespace parray::coordinator
