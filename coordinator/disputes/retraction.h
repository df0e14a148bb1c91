#pragma once

#include <optional>

#include "coordinator/disputes/fault_findings.h"
#include "coordinator/jobs/job_picture.h"
#include "coordinator/store/store.h"

namespace parray::coordinator {

/// Reads the findings in a store. Throws RunError if its note of workers is damaged.
FaultFindings kept_findings(Store& store);

/// Retracts the results and checks of a faulty machine: in the picture, in the job's log and in its
/// record, which it puts into the store. Returns nothing if the picture does not rely on the
/// machine. `at`: seconds since 1970. `store` may be null.
std::optional<JobPicture::Retraction> retract_results(JobPicture& picture, Store* store,
                                                      JobRecord& record,
                                                      const FaultFinding& finding, double at);

}  // namespace parray::coordinator
