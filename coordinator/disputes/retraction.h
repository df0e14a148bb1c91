#pragma once

#include <optional>

#include "coordinator/disputes/fault_findings.h"
#include "coordinator/jobs/job_picture.h"
#include "coordinator/store/store.h"

namespace parray::coordinator {

/// Reads the findings about faulty machines from a store: from its note "workers", which
/// DisputeDesk::keep_worker_notes() writes. Returns no findings if the store has no such note.
/// Throws RunError if the note is damaged.
FaultFindings kept_findings(Store& store);

/// Removes the cells and the checks of the faulty machine `finding.machine` from the picture.
/// Removes them from the job's log, too, and adds the retraction to its journal. Sets the flag in
/// `record`, which users see. If the picture does not rely on the machine, does none of this and
/// returns nothing.
///
/// In both cases notes `finding.number` in `record` and writes `record` to the store. `at`: seconds
/// since 1970. `store` null: nothing is kept on a disk, so only `picture` and `record` change.
std::optional<JobPicture::Retraction> retract_results(JobPicture& picture, Store* store,
                                                      JobRecord& record,
                                                      const FaultFinding& finding, double at);

}  // namespace parray::coordinator
