#pragma once

#include <optional>

#include "coordinator/disputes/fault_findings.h"
#include "coordinator/jobs/job_picture.h"
#include "coordinator/store/store.h"

namespace parray::coordinator {

/// The fault_findings that a state keeps. Throws RunError when its note of workers is damaged.
FaultFindings kept_findings(Store& store);

/// Sets back what a found_faulty machine has traced or checked: in the picture, in the job's rows
/// and in its record, which it puts into the store. Returns what was set back; nothing: the picture
/// does not rely on the machine. `at`: seconds since 1970. `store` may be null.
std::optional<JobPicture::Retraction> undo(JobPicture& picture, Store* store, JobRecord& record,
                                           const FaultFinding& finding, double at);

}  // namespace parray::coordinator
